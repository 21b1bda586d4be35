N0010 (ID,PROG, 350021, Finish pass: flange, collar, cone, knob)
N0020 ! Diameter 5.30: every size of this family has a program of its own
N0030 ! The programmed point is the centre of the tool nose, radius 0.03125 in
N0040 ! Diameters, inch; z = 0 at the top of the knob
N0050 ! P42: machine z where the part's z is 2.0, set when the tool touches the face
N0150 G70                     ! Inch
N0160 T0100                   ! Finishing tool
N0170 T0                      ! Its data out of the control for the approach
N0190 G94 G97 T0 M53          ! Inch per minute, revolutions, high range
N0200 M03 S3000
N0210 G00 X0 Z(P42)
N0220 G92 X30.4 Z2.0          ! Part coordinates from here on
N0230 T0100
N0240 G00 X6.2625 Z-4.31875 T0101 M08
N0244 (UPD, 1, TOV(X), 0.00000)
N0245 (UPD, 1, TOV(Z), 0.00000)
N0250 G00 X6.2625 Z-4.21875   ! Always arrive in the same direction
N0260 G04 X5.0                ! Spindle and coolant come up
N0270 G95
N0280 G01 F0.005 X5.36250 Z-4.21875                     ! Flange face
N0290 G01 X5.36250 Z-3.71875                            ! Collar
N0300 G01 X4.83636 Z-3.71875                            ! Step face
N0310 G01 X2.45254 Z-1.62131                            ! Cone
N0320 G02 X0.00000 Z0.03125 F0.005 I-1.22627 K0.37131   ! Knob: more than a quadrant
N0330 G01 X-0.05000 Z0.03125                            ! A little past the axis
N0340 G00 Z0.14125
N0350 G00 X6.2625
N0360 G94
N0370 G01 F100.0 X30.4 Z2.0 T00 M05 M09
N0380 G92 X0 Z(P42)           ! Machine coordinates again
N0390 G00 X0 Z10
/N0400 P42=(P42-0.02)         ! The next part is cut 0.02 in deeper into the bar
N0410 M30
N9999 (END, PROG)
