# Energy of the scene from a trace: kinetic, gravity and all springs.
# usage: gnuplot -e "dir='out'" sim/plots/energy.gp   ->  out/energy.png
set terminal pngcairo size 1200,500 font ",11"
set output dir."/energy.png"
set datafile separator ","
set grid
set lmargin 14
set rmargin 6
set title "energy: motion, gravity, all springs"
set ylabel "energy (J)"
set xlabel "t (s)"
set format x "%g"
plot dir."/trace.csv" using (column("t")):(column("energy")) with lines lc rgb "#333333" notitle
