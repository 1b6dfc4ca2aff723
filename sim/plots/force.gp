# Displayed force and torque, from a trace.
# usage: gnuplot -e "dir='out'; body='tool'" sim/plots/force.gp   ->  out/force.png
# for a device that grips bodies: bodies='tool brick', all of them in the order of the scene file
set terminal pngcairo size 1200,800 font ",11"
set output dir."/force.png"
set datafile separator ","
trace = dir."/trace.csv"

load "sim/plots/held.gp"
length(x, y, z) = sqrt(x * x + y * y + z * z)

load "sim/plots/gaps.gp"

set grid
set key outside right top
set lmargin 14
set rmargin 20
set format x ""
set multiplot layout 2,1 title "shown to the hand: ".what noenhanced
set ylabel "force (N)"
plot trace using (column("t")):(gap(0)) axes x1y2 with impulses lc rgb "#ffe0b0" title "held", \
     trace using (column("t")):(length(shown("fx"), shown("fy"), shown("fz"))) with lines lw 3 lc rgb "#cccccc" title "magnitude", \
     trace using (column("t")):(shown("fx")) with lines lc rgb "#c0392b" title "x", \
     trace using (column("t")):(shown("fy")) with lines lc rgb "#2e7d32" title "y", \
     trace using (column("t")):(shown("fz")) with lines lc rgb "#1f4e9c" title "z"
set ylabel "torque (N m)"
set offsets 0, 0, 1e-6, 1e-6  # a scene may display no torque
set xlabel "t (s)"
set format x "%g"
plot trace using (column("t")):(gap(0)) axes x1y2 with impulses lc rgb "#ffe0b0" title "held", \
     trace using (column("t")):(length(shown("tx"), shown("ty"), shown("tz"))) with lines lw 3 lc rgb "#cccccc" title "magnitude", \
     trace using (column("t")):(shown("tx")) with lines lc rgb "#c0392b" title "x", \
     trace using (column("t")):(shown("ty")) with lines lc rgb "#2e7d32" title "y", \
     trace using (column("t")):(shown("tz")) with lines lc rgb "#1f4e9c" title "z"
unset multiplot
