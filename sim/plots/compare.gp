# One column of several traces over each other.
# usage: gnuplot -e "traces='a.csv b.csv'; column='tool.x'; picture='out/compare.png'" sim/plots/compare.gp
# from, to: s, of the motion; without them all of it
set terminal pngcairo size 800,400 font ",11"
set output picture
set datafile separator ","
if (!exists("from")) from = 0
if (!exists("to")) to = 1e30
set grid
set key outside right top
set xlabel "t (s)"
set ylabel column noenhanced
plot for [trace in traces] trace using (column("t") >= from && column("t") <= to ? column("t") : NaN):(column(column)) \
     with lines lw 2 title trace noenhanced
