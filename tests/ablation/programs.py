"""Programs that an ablation runs: tests of the core with their sweeps, and the stability map (tests/study/map).

A unit is a group of sources compiled as one. These are the tests named in core/tuning.h and the sweeps beside them.
"""
import pathlib

STEPS = ["tests/core/contact/steps_one_tool.cc", "tests/core/contact/bodies/steps_few_bodies.cc",
         "tests/core/contact/bodies/steps_jointed.cc", "tests/core/joint/steps_articulated.cc",
         "tests/core/net/steps_net.cc"]
MAP = [f"tests/study/map/{name}.cc" for name in
       "cases cases_of_joints command mechanisms piles sample section shard tools steps main".split()]
MAP += ["tests/study/figure.cc", "tests/study/tool.cc"]
TESTS = {
    "articulated": ("joint", ["heavy_ends stabilisation stops contradicted_targets",
                              "tool_energy tool_stability turns reference", "wound_targets"]),
    "bodies": ("contact/bodies", ["angular_momentum contradicted_hinge joint_stability joints",
                                  "laws momentum stability solver_limits", "overlap ridges edges drawn_piles",
                                  "shapes_meet shapes_on_posts stacks pressed_grippers", "few_blocks", "sticking"]),
    "nets": ("net", ["attached_sweep attached floating forces", "friction friction_threshold momentum on_joints",
                     "statics stability reference one_iteration", "faces"]),
    "contacts": ("contact", ["energy_of_contacts nearest_points pressed_rest pressed_tool",
                             "reference stability tunnelling valleys", "friction", "sample_gaps",
                             "thrown_tools rolling"]),
    "free": (".", ["stability energy_rise", "second_order"]),
    "terms": ("term", ["gears", "loops"]),
}
FLAGS = ("-std=c++20 -O1 -march=x86-64-v3 -DNDEBUG -DEIGEN_DONT_VECTORIZE -DGODOBJECT_NO_FLATTEN -fno-tree-vectorize "
         "-fno-tree-slp-vectorize -fno-math-errno -w -DGODOBJECT_SOURCE_DIR='\"{source}\"' -I{out} -I. "
         "-isystem /usr/include/eigen3")


def write_build(source, out):
    """Writes out/build.ninja for all programs. Sources find the copy of core before core itself."""
    flags = FLAGS.format(source=source, out=out.relative_to(source))
    rules = [f"builddir = {out.relative_to(source)}", "rule cc\n  command = g++ $flags -MD -MF $out.d -c $in -o $out\n  depfile = $out.d\n  deps = gcc",
             "rule ld\n  command = g++ $in -o $out $libs"]
    known = set()

    def objects(files):
        names = []
        for file in files:
            name = f"{out.relative_to(source)}/obj/{str(file).replace('/', '_')}.o"
            if name not in known:
                rules.append(f"build {name}: cc {file}\n  flags = {flags}")
            known.add(name)
            names.append(name)
        return " ".join(names)

    oracle = [str(path.relative_to(source)) for path in sorted((source / "tests/oracle").rglob("*.cc"))
              if not path.name.startswith("test_")]
    common = objects(STEPS + oracle)
    rules.append(f"build {out.relative_to(source)}/map: ld {objects(MAP)} {common}\n"
                 "  libs = -lgtest -lpthread -ldl")
    (out / "unit").mkdir(parents=True, exist_ok=True)
    for program, (folder, units) in TESTS.items():
        files = ["tests/support/allocation_guard.cc"]
        for unit in units:
            path = out / "unit" / f"{program}_{unit.split()[0]}.cc"
            text = "".join(f'#include "{pathlib.PurePosixPath("tests/core", folder)}/test_{name}.cc"\n'
                           for name in unit.split())
            if not path.exists() or path.read_text() != text:
                path.write_text(text)
            files.append(path.relative_to(source))
        rules.append(f"build {out.relative_to(source)}/{program}: ld {objects(files)} {common}\n"
                     "  libs = -lgmock_main -lgmock -lgtest -lpthread -ldl")
    (out / "build.ninja").write_text("\n".join(rules) + "\n")
