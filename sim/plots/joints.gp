# Force and torque of every joint on its child, from a trace.
# usage: gnuplot -e "dir='out'; body='pivot sleeve'" sim/plots/joints.gp   ->  out/joints.png
set terminal pngcairo size 1200,800 font ",11"
set output dir."/joints.png"
set datafile separator ","
trace = dir."/trace.csv"

length(joint, a) = sqrt(column(joint.".".a."x")**2 + column(joint.".".a."y")**2 + column(joint.".".a."z")**2)

load "sim/plots/gaps.gp"

set grid
set key outside right top
set lmargin 14
set rmargin 20
set format x ""
set multiplot layout 2,1 title "joints"
set ylabel "force (N)"
set yrange [0:1e-9 < *]  # rounding errors are not enlarged
plot trace using (column("t")):(gap(0)) axes x1y2 with impulses lc rgb "#ffe0b0" title "held", \
     for [joint in body] trace using (column("t")):(length(joint, "f")) with lines lw 2 title joint noenhanced
set ylabel "torque (N m)"
set xlabel "t (s)"
set format x "%g"
plot trace using (column("t")):(gap(0)) axes x1y2 with impulses lc rgb "#ffe0b0" title "held", \
     for [joint in body] trace using (column("t")):(length(joint, "t")) with lines lw 2 title joint noenhanced
unset multiplot
