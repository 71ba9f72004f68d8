# Draws docs/local-basis.svg: gnuplot docs/local-basis.gnuplot, in the directory above.
set terminal svg size 900,360 font 'sans,13'
set output 'docs/local-basis.svg'
set multiplot layout 1,2
set samples 400
unset key

b1(s) = s
b2(s) = s*s - s
b3(s) = (2*s*s*s - 3*s*s + s)
piece(s, a, h, from, q1, q2, q3) = from + q1*b1((s-a)/h) + q2*b2((s-a)/h) + q3*b3((s-a)/h)
phi(s) = s < 0.4 ? piece(s, 0, 0.4, 0, 0.7, 0.5, 0) : s < 0.7 ? piece(s, 0.4, 0.3, 0.7, -0.5, 0.6, 1.2) : piece(s, 0.7, 0.3, 0.2, 0.4, -0.5, 0)
set title 'the angle along the rod: one sum on each piece'
set xlabel 'arc length'
set ylabel 'angle phi'
set yrange [-0.2:1]
set xtics ('a_0' 0, 'a_1 (contact)' 0.4, 'a_2' 0.7, 'a_3' 1)
set ytics 0.5
do for [i=1:2] { x = i == 1 ? 0.4 : 0.7; set arrow i from x,-0.2 to x,1 nohead dashtype 2 lc rgb '#888888' }
plot [0:1] phi(x) with lines lw 3 lc rgb '#2060a0'

unset arrow
set title 'local basis: every function begins at 0'
set xlabel 'sigma, from 0 to 1 on the piece'
set ylabel 'beta_i'
set yrange [-0.4:1.1]
set xtics ('0' 0, '1' 1)
set key top left
plot [0:1] b1(x) title 'beta_1' with lines lw 2, b2(x) title 'beta_2' with lines lw 2, b3(x) title 'beta_3' with lines lw 2, \
  '-' notitle with points pt 7 ps 1 lc rgb 'black'
0 0
e
