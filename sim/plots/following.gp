# Target, tool and their distance, from a trace.
# usage: gnuplot -e "dir='out'; body='tool'" sim/plots/following.gp   ->  out/following.png
# for a device that grips bodies: bodies='tool brick', all of them in the order of the scene file
set terminal pngcairo size 1200,1000 font ",11"
set output dir."/following.png"
set datafile separator ","
trace = dir."/trace.csv"

load "sim/plots/held.gp"
sq(x) = x * x
distance(dummy) = sqrt(sq(of_target("x") - of_tool("x")) + sq(of_target("y") - of_tool("y")) + sq(of_target("z") - of_tool("z")))
# |q_target -+ q_tool| = 2 sin(angle / 4): exact for small angles too; -q is the same attitude as q
chord(sign) = sqrt(sq(of_target("qw") - sign * of_tool("qw")) + sq(of_target("qx") - sign * of_tool("qx")) \
                   + sq(of_target("qy") - sign * of_tool("qy")) + sq(of_target("qz") - sign * of_tool("qz")))
nearer_chord(dummy) = chord(1) < chord(-1) ? chord(1) : chord(-1)
angle(dummy) = 4 * asin(nearer_chord(0) / 2)

load "sim/plots/gaps.gp"

set grid
set key outside right top
set lmargin 14
set rmargin 20
set format x ""
set multiplot layout 3,1 title "following: ".what noenhanced
set ylabel "position (m)"
plot trace using (column("t")):(gap(0)) axes x1y2 with impulses lc rgb "#ffe0b0" title "held", \
     trace using (column("t")):(of_target("x")) with lines lw 3 lc rgb "#f4b6a6" title "target x", \
     trace using (column("t")):(of_target("y")) with lines lw 3 lc rgb "#b7dcb0" title "target y", \
     trace using (column("t")):(of_target("z")) with lines lw 3 lc rgb "#b0c8ea" title "target z", \
     trace using (column("t")):(of_tool("x")) with lines lc rgb "#c0392b" title "tool x", \
     trace using (column("t")):(of_tool("y")) with lines lc rgb "#2e7d32" title "tool y", \
     trace using (column("t")):(of_tool("z")) with lines lc rgb "#1f4e9c" title "tool z"
set ylabel "distance to target (mm)"
set yrange [0:1e-6 < *]  # the distance may be zero throughout
plot trace using (column("t")):(gap(0)) axes x1y2 with impulses lc rgb "#ffe0b0" title "held", \
     trace using (column("t")):(1e3 * distance(0)) with lines lc rgb "#333333" notitle
set ylabel "rotation to target (deg)"
set xlabel "t (s)"
set format x "%g"
plot trace using (column("t")):(gap(0)) axes x1y2 with impulses lc rgb "#ffe0b0" title "held", \
     trace using (column("t")):(180 / pi * angle(0)) with lines lc rgb "#333333" notitle
unset multiplot
