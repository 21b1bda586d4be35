N0010 (ID,PROG, 060021, Finish pass: two cylinders, two faces)
N0020 ! One program for a family of parts, each 0.04 in smaller than the one before
N0030 ! The programmed point is the centre of the tool nose, radius 0.03125 in
N0040 ! Diameters, inch; z = 0 at the end face
N0050 ! P42: machine z where the part's z is 2.0, set when the tool touches the face
N0060 ! P46: diameter of the large cylinder
N0070 ! P44, P45, P47, P48: tapers cut on purpose, to try the compensation; else 0
N0110 G70                     ! Inch
N0120 T0100                   ! Finishing tool
N0130 T0                      ! Its data out of the control for the approach
N0140 G94 G97 T0 M53          ! Inch per minute, revolutions, high range
N0150 M03 S3000
N0160 G00 X0 Z(P42)
N0170 G92 X30.4 Z2.0 S3000    ! Part coordinates from here on
N0180 T0100
N0190 G00 X6.2625 Z-3.96875 T0101 M08
N0200 (UPD, 1, TOV(X), 0.00000)
N0205 (UPD, 1, TOV(Z), 0.00000)
N0210 G04 X5.0                ! Spindle and coolant come up
N0220 G95
N0230 G01 F.005 X(P46+0.0625) Z-3.96875       ! To the large cylinder
N0240 G01 X(P46+0.0625+P47) Z-1.96875         ! Large cylinder, its end moved by P47
N0250 G01 X(P46+0.0625-3.9) Z(-1.96875+P44)   ! Step face, its inner end by P44
N0260 G01 X(P46+0.0625-3.9+P48) Z00.03125     ! Small cylinder, its end by P48
N0270 G01 X-0.03125 Z(00.03125+P45)           ! End face, its middle by P45
N0280 G01 Z00.13125
N0290 G00 X6.2625
N0300 G94
N0310 G01 F100.0 X30.4 Z2.0 T00 M05 M09
N0320 G92 X0 Z(P42)           ! Machine coordinates again
N0330 G00 X0 Z10
/N0340 P42=(P42-0.02)         ! The next part is cut 0.02 in deeper into the bar
N0350 M30
N9999 (END, PROG)
