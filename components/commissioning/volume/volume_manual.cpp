// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/volume/volume_manual.hpp"

namespace plumb::commissioning {

hal::CommandPage volume_page() {
    return {
        "plumb-volume",
        "reversal|turn|circle|diagonals|straightedge|block|import|export|uncertainty [FILES] [options]",
        {{"DESCRIPTION",
          R"(plumb volume measures the errors of axes that squareness(9) corrects by tables, reads and writes tables of other
controls, and states how sure the whole is. Errors are actual minus nominal, in mm and rad, never corrections. Each command states
the uncertainty of its result, k = 2, and the errors that the measurement cannot see.

READINGS.csv and the other tables of measured values may be separated by tabs, semicolons or commas, and have a decimal comma. Values
are in mm and deg unless a head states another unit, as in up1 (um). The program states how it read such a table, and names the
columns that it did not read.

plumb volume COMMAND --help prints the options of a command.)"},
         {"REVERSAL",
          R"(plumb volume reversal READINGS.csv --axis X --output x.csv makes the direction columns EXX+ and EXX- of lost motion.
Approach each position from both sides, each time from at least five times the lost motion away, five times at three places or
more. READINGS.csv has the columns position,up1,up2,...,down1,down2,... in mm: up after motion to the + end. An indicator
counts up as the axis moves to its + end.

  position,up1,up2,up3,down1,down2,down3
  100,0.0001,-0.0002,0.0001,0.0102,0.0099,0.0101
  300,0.0002,0.0001,-0.0001,0.0098,0.0101,0.0100

--scale keeps the mean of both directions, too: for a laser or a scale; --scale-u 0.8um/m is the standard uncertainty of its own
scale, without which the scale of the axis counts as unknown. An indicator at each place has its own zero, and shows no
scale. A reading is the place that the axis reached, less the position. If the readings show a table that leads, up and down are
probably swapped, and the file is refused; --leads is for a BACKLASH in force that is too large. A drift from one run to the next is
named, and is in the uncertainty. --own-u is the standard uncertainty of the indicator's own hysteresis; repeating does not reduce it. --into TABLE
puts the result into a table that the axis has already.

--recording reads the columns motor,load instead: the encoder of the motor and a scale at the load, over any program.

BACKLASH and COMP_FILE of LinuxCNC correct the same error. Delete their lines before you use the table. --ini refuses a table
beside them.)"},
         {"TURN",
          R"(plumb volume turn --lost-motion 10um --feed 3000 --radius 50 predicts, before the cut, the error of a corrected circle where an
axis turns: the correction needs some milliseconds for its way. It prints, by radius, the largest feed at which the error stays
within --allowed 2um. --acceleration is reversal-acceleration of squareness, --distance its reversal-distance. The correction never
makes the circular deviation G larger. If the turn comes late, it can make the largest distance from the mean circle larger.)"},
         {"CIRCLE",
          R"(plumb volume circle CCW.csv CW.csv reads paths of a ballbar after ISO 230-4: lines angle,radius in deg and mm, below a
head:

  # plane: XY
  # radius: 150
  # feed: 2000
  # direction: CCW
  # object: part
  angle,radius

The unit of feed is mm/min. The angle is the place on the circle, from the + end of the first axis of the plane to the + end of
the second one, in both directions of motion. For the panel, # correction: off or on says whether squareness corrected this
path. plumb volume prints G of each direction, G(b), F and D, and the opening of the corner, the difference of the scales,
lost motion, play across and the difference of the servo lags. From both directions it prints the option --opening of
plumb squareness. One direction alone gives opening and lag as one sum.)"},
         {"DIAGONALS",
          R"(plumb volume diagonals --box 800,600,500 --deviations 3um,-5um,2um,1um --u 1um reads the four body diagonals after
ISO 230-6, measured minus nominal length, in the order PPP, NPP, PNP, NNP. N marks an axis that goes to its - end. It prints the
openings of the three corners, with the options of plumb squareness, and the mean scale. Equal diagonals do not prove a good volume: 10 um/m in X
and 17.8 um/m in Y read alike on 800 x 600.)"},
         {"STRAIGHTEDGE AND BLOCK",
          R"(plumb volume straightedge EDGE.csv --error EYX makes a table of straightness from a straightedge that you turn over
about its length. Columns: position,before,turned in mm. Before, the plunger points to the + end of the axis across; then the edge
is turned over, and the plunger points to the - end, on the same line of its face. Both readings count up as the plunger is
pressed in. The edge's own error drops out.

plumb volume block --bore 30 --measured 27.012 --ball 3 --pre-travel 4um gives the lost motion of an axis from a gauge bore or
block and a probe: measured bore = D - ball + 2 pre-travel + B; --boss W = W + ball - 2 pre-travel - B. A probe cannot separate
B from its own pre-travel, which an axis with a scale at the load shows.)"},
         {"FILES OF OTHERS",
          R"(plumb volume import --from linuxcnc FILE --axis X --type 1 prints the table that a COMP_FILE of LinuxCNC describes, and the
sign in words. --from rtl reads Renishaw's .rtl of a linear measurement: um, measured minus target. Targets rise or fall, and runs
come back or all go the same way; then the lost motion stays unknown. --scale-u 0.8um/m is the standard uncertainty of the
laser's own scale, without which the scale counts as unknown. Straightness and angles are refused, unless you give
--error EYX and --unit um, or --error ECX and --unit urad, mrad or arcsec. --from isg reads the CSV of ISG and Beckhoff (names, then
lines of numbers between blanks, mm and rad), --from heidenhain a table .COM (AXISPOS, BACKLASH, a column for each axis), --from cec
the lines $AN_CEC of a SINUMERIK; --error EYX selects another error than the scale. Their makers do not state the sign in public:
check it with one move. --zero POS
shifts the table to 0 there, --negate turns its sign. --unit inch is for a COMP_FILE of an inch machine. --output writes the
table. Its date is --date, or the date of the file. A bad line is refused with file, line and reason, and nothing is written.

plumb volume export --to linuxcnc TABLE --axis X --type 1 writes a COMP_FILE, --to rtl an .rtl file, --to isg, heidenhain or cec the
others. Each holds one error of one axis: COMP_FILE, .rtl, .COM and CEC in both directions, the CSV of ISG the mean of both. CEC has
even steps; a table with uneven places is written at finer steps, linear between the rows.)"},
         {"UNCERTAINTY",
          R"(plumb volume uncertainty --chain w-X.b-Y-Z-t --box X=0:800,Y=0:600,Z=-500:0 --tool T3=0,0,-200 --tilt
EC0Y=-80urad,u=4urad --table y.csv states how far two places of the work may be off each other after correction: U is twice the
standard uncertainty in the worst direction. One measurement that set several angles is --common NAME,EC0Y=1,EC0X=0.5,u=3urad.
Other causes: --repeatability X=0.5um, --tool-u 2um for its length. The work space may have the place of a clamped axis, as
W=300. Rotary axes of the chain stand at 0, and their own errors are not in U. Tables state theirs in their head, for each value, and for
all rows together, per mm of the position or constant:

  # u: EXX 0.5e-3, EXX+ 0.2e-3
  # u-common: EXX 0.8e-6 per X

EXX+ in the head is half of the difference by direction. 2,000 machines are drawn; --seed and --draws change that.

The report lists all errors of the chain. It states of each error that it is measured (with instrument and date), assumed (with its
source) or unknown. While one error is unknown, the report states "at least +- U", and how to measure that error.
State by=square and the date in --tilt, and # by: in the head of a table.

--assume iso-10791 takes the tolerances of ISO 10791 for machining centres, by the length of the work space. --assume sheet.csv takes
your own values, each with its source:

  error,u,source
  EYX,3um,sheet of the maker, 2019
  lost motion X,4um,sheet of the maker, 2019
  second axis,2um,level along Y at both ends of Z
  bending,5urad/K,square on a cold and on a warm day

Write each error as the list names it. u is a standard uncertainty: half of a stated "+-" with k = 2. Of two sources that name one
error the first one counts. A measured error keeps its measured u.

A measurement ages. The head of a table may state its date, how long it is valid, and the standard uncertainty that a year adds:

  # date: 2026-11-20
  # temperature: 20.1 degC
  # valid-for: 365 d
  # drift: EXX 2e-6 per X

reversal and straightedge write the date of today, or --date; reversal writes # repeatability: EXX 0.4e-3, too. An older table is
named, and without a drift its drift is an unknown error. Without a date, or if the clock is not set, valid-for counts as the age. A
table that ends within the work space is named: beyond its end the error is unknown. --tilt takes drift=2urad and date=2026-11-20.
With # temperature in each table, --temperature 26degC states the growth since then: between 0 and 11.5 um/m for each K, on a
thermometer that is off by 0.3 K. --pivot Y=300 is the pivot in force.

Direction columns correct nothing while the direction of an axis is not known: from the start, and after machine on, until the axis
has moved by its lost motion. The report states how much that adds.

The report ends with the four body diagonals, before and after correction, as predicted. --steps PPP=steps.csv compares the
steps of a laser along a diagonal with the prediction: columns distance,deviation in mm, measured minus nominal. Steps check the
tables, and never fill one: the alignment of laser and mirror enters. They do not see errors across the diagonal.)"},
         {"EXIT STATUS", R"(0 after success; 1 if a file or value is refused; 2 for a wrong command line.)"},
         {"LIMITS",
          R"(Uncorrected, and not in U: the orientation of the tool, the spindle, cutting force, the mass of the work, contour
error, and the part of a correction that joint_offset keeps back near a soft limit.)"}},
        ".BR plumb (1),\n.BR plumb-squareness (1),\n.BR squareness (9)"};
}

}  // namespace plumb::commissioning
