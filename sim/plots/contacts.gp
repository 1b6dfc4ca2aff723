# Contacts from a trace: depth, force and number.
# usage: gnuplot -e "dir='out'" sim/plots/contacts.gp   ->  out/contacts.png
set terminal pngcairo size 1200,1100 font ",11"
set output dir."/contacts.png"
rows = "< awk -F, -f sim/plots/contacts.awk '".dir."/trace.csv'"

set grid
set key outside right top
set lmargin 14
set rmargin 26
set format x ""
set yrange [0:1e-6 < *]  # the trace may have no contact
set multiplot layout 3,1 title "contacts"
set ylabel "deepest penetration (mm)"
plot rows using 1:(1e3 * $2) with lines lc rgb "#333333" notitle
set ylabel "force (N)"
plot rows using 1:4 with lines lw 2 lc rgb "#c0392b" title "largest on a body", \
     rows using 1:5 with lines lc rgb "#1f4e9c" title "residual"
set ylabel "contacts that bear a force"
set xlabel "t (s)"
set format x "%g"
plot rows using 1:3 with steps lc rgb "#2e7d32" notitle
unset multiplot
