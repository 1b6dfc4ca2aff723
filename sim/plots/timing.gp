# Histograms of wake-up and compute time, from a report.
# usage: gnuplot -e "dir='out'" sim/plots/timing.gp   ->  out/timing.png
set terminal pngcairo size 1200,800 font ",11"
set output dir."/timing.png"
histogram(name) = "< python3 sim/plots/histogram.py '".dir."/report.json' ".name

set grid
set logscale xy
set yrange [0.5:*]
set ylabel "cycles"
set lmargin 10
set multiplot layout 2,1 title "time per cycle"
set xlabel "wake-up after the start of the cycle (us), upper edge of the bin"
plot histogram("wake_us") using 1:2 with impulses lw 3 lc rgb "#1f4e9c" notitle
set xlabel "compute time (us), upper edge of the bin"
plot histogram("compute_us") using 1:2 with impulses lw 3 lc rgb "#c0392b" notitle
unset multiplot
