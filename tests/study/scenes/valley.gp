# Displayed force of a ball in a valley of one mesh, and of two planes.
# usage: gnuplot -e "dir='out/study'" tests/study/scenes/valley.gp
set terminal pngcairo size 960,360 font ",10"
set output dir."/valley.png"
set datafile separator ","
set grid
set xlabel "t (s)"
set key center right
set multiplot layout 1,2
set ylabel "displayed force (N)"
plot dir."/valley.csv" using "t":"tool.feedback.fz" with lines lw 5 lc rgb "#9dc3e6" title "mesh, up", \
     dir."/valley-planes.csv" using "t":"tool.feedback.fz" with lines dt 2 lc rgb "#1f4e79" title "planes, up", \
     dir."/valley.csv" using "t":"tool.feedback.fx" with lines lw 5 lc rgb "#f4b183" title "mesh, across", \
     dir."/valley-planes.csv" using "t":"tool.feedback.fx" with lines dt 2 lc rgb "#843c0c" title "planes, across"
unset key
set ylabel "deepest contact (mm)"
plot dir."/valley.csv" using "t":(1e3 * column("penetration")) with lines lw 5 lc rgb "#9dc3e6", \
     dir."/valley-planes.csv" using "t":(1e3 * column("penetration")) with lines dt 2 lc rgb "#1f4e79"
