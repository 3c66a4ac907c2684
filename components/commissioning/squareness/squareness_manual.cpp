// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/squareness/squareness_manual.hpp"

namespace plumb::commissioning {

hal::CommandPage squareness_page() {
    return {
        "plumb-squareness",
        "[--chain CHAIN] [tilts or measurements] [options]",
        {{"DESCRIPTION",
          R"(plumb squareness computes the settings of the component squareness. Give it the leaning of the axes, the
quantities of ISO 230-1, or measurements with diagonals, square and indicator, or a probe. It prints the direction and the
angle of each tilt with its uncertainty, the lines for the .hal file, and one test move for each sign.

Without tilts and measurements it lists the tilts that the chain can have. Rotary axes of the chain, as in w-C-A-Y.b-X-Z-t, stand
at 0 while you measure.

An ANGLE is a number with a unit, rad, mrad, urad, deg, arcmin or arcsec, or a length per length: 60um/m, 0.06mm/m,
0.02mm/300mm, 0.001in/ft, 0.02/300. A LENGTH is a number with um, mm, cm, m, in, ft or thou. Numbers have a decimal
point.)"},
         {"SIGNS",
          R"(An axis leans towards D if its + end is off towards D. For an axis that carries the work, the + end is the end to
which the tool goes, seen from the work. For a ram it is the end away from its nose. An axis leans to one of two opposite
directions only; both together are refused.

  axis  leans to  is        axis  leans to  is        axis  leans to  is
  Y, V  +X        EC0Y -    Z, W  +X        EB0Z +    X, U  +Y        EC0X +
  Y, V  -X        EC0Y +    Z, W  -X        EB0Z -    X, U  -Y        EC0X -
  Y, V  +Z        EA0Y +    Z, W  +Y        EA0Z -    X, U  +Z        EB0X -
  Y, V  -Z        EA0Y -    Z, W  -Y        EA0Z +    X, U  -Z        EB0X +

A is about X, B about Y, C about Z, positive as a right hand turns: +C takes +X towards +Y. The last letter names the
axis: EC0V.)"},
         {"MEASURING",
          R"(1. Switch the correction off and let the machine settle. Otherwise the result is only the remaining error.
2. Measure over the travel of your work. A tilt is valid for this travel; straightness enters into it.
3. Give each measurement as KEY=VALUE,KEY=VALUE without blanks, as in the sections below.
4. Copy the setp lines into the settings file, and make the test move.

A measurement gives the angle between the + ends of two axes. As in ISO 230-1, one of them is the datum and the other one
leans: of X and Y it is Y, by EC0Y, unless --datum selects another one. If you know that the datum itself leans, give that
by --lean or --iso. Where one axis carries another, it turns that too (--reading, --against). So one measurement can give two
angles, and an angle can follow from two measurements.

A square shows the corner between two axes, not which of them leans. Where Y carries X, as on the table of w-X-Y.b-Z-C-t,
the corner stays as it is when Y leans. So give the reading of a square or of diagonals as a measurement, not by --lean.

A beam on two motors, as X on Y in w.b-Y-X-Z-t, leans by itself, and the rails of Y keep their direction: measure with
--datum Y,X. It is EC0X then; EC0Y would correct nothing of it. --gantry Y=0mm:1200mm gives the change of HOME_OFFSET that
turns the beam square by its motors.

These fields are common to all measurements:

  u=LENGTH         standard uncertainty of a single reading; U is twice u
  own-u=ANGLE      u of the artifact or square itself; 0 without this field
  object=part      these axes have drawn the shape: they cut the part, or
                   moved along a path for a laser or a ballbar
  object=artifact  the shape is true, and a probe on these axes measured it

object decides the sign: if axes cut a part that is longer along a diagonal, they measure a true artifact as shorter along it.

Several measurements of the same axes become their weighted mean. If readings scatter more than stated, the uncertainty is
widened; it is never narrowed. Repeating does not reduce own-u: it belongs to one square. State u
honestly: the scatter of a few readings shows little.)"},
         {"DIAGONALS",
          R"(For a square or rectangle whose sides lie along the axes:

  --diagonals plane=XY,object=part,rising=565.709mm,falling=565.662mm,u=1um

rising is the diagonal from the corner at both - ends to the corner at both + ends; falling is the other one. A rectangle
also needs sides=400:300mm, the first along the first axis of the plane. For an artifact that is known to be out of square
add own=ANGLE, the amount by which its corner at both - ends is more than 90 deg.)"},
         {"SQUARE AND INDICATOR",
          R"(Readings of the same leg at two heights, or at more places along a travel:

  --square move=Y,plunger=+X,at=0:300mm,reads=0:24um,turned=0:-20um,u=1um

One leg of the square lies along an axis, here X. True it by moving that axis. An indicator on the tool's side touches the
other leg while the axis move, here Y, runs along it.

  plunger  direction in which the plunger of the indicator points
  at       positions of the axis
  reads    readings there; they increase as the plunger is pressed in
  turned   readings after turning the square by half a turn about the
           leg that is touched

For turned, touch the same face from the other side, with the plunger in the opposite direction, at the same positions. This
cancels the error of the square. Two readings are enough; more are better. In a list without units, the last value has
the unit for all.)"},
         {"OPENING",
          R"(A corner that plumb volume circle or plumb volume diagonals gives:

  --opening plane=XY,object=part,angle=50urad,u=0.4urad

angle is the amount by which the corner at both - ends is more than 90 deg. u is an ANGLE.)"},
         {"PROBED POINTS",
          R"(Points on the faces of a square or polygon, or around a ring:

  --points file=square.csv,object=artifact,u=0.5um

Add unit=in if they are not in mm, or state units in the heads, as in X (in). The header of the file names its columns: the two axes of the plane; normal, the direction
of the face in deg from the + end of the axis that comes first in XYZUVW towards that of the other; and turned, the
angle in deg by which the artifact was turned before. Without normal it is a ring. Lines that begin with # are comments.

  X,Y,normal,turned
  152.013,-120.5,0,0
  152.010,120.5,0,0
  -120.5,151.998,90,0
  120.5,152.021,90,0

A program of LinuxCNC writes such a file with (LOGOPEN,square.csv), (LOG,X,Y,normal,turned), and (LOG,#5061,#5062,0,0) after
each G38.2 onto a face that looks to +X.

You need two points on each of two faces that are neither parallel nor at 45 deg to the axes, or five around a ring; more
are better. You need not correct them for the ball of the probe. To separate the error of the artifact from the error of the axes,
turn it by 90 deg and probe it again. own-u is the direction of a face, an ANGLE, or the ovality of a ring, a LENGTH.

The file has no checksum. With more points than necessary, a damaged digit makes a point leave the shape, and the file is
refused with its line, or the change is within the uncertainty.)"},
         {"BEFORE AND AFTER",
          R"(The output compares each two axes over 1 m, or 1 ft on an inch machine: before, with --in-force, and after, with the new
settings. A correction leaves 0, with an uncertainty (k=2) from all measurements and given angles: about 95 of 100 machines
are within it. Straightness is not included. Two axes without a measurement are named.

On a machine with angles in force, switch the correction off before you measure, and add --correction off. Your angles then
take the place of the same angles in force; all others stay. With the correction on, your angles are added.

Two measurements of the same axes that are more than ten times their uncertainty apart are refused: a sign or a unit is
wrong.)"},
         {"JSON",
          R"(A document gives the whole machine at once, for a screen or a script:

  plumb squareness --input machine.json --json

  {"chain": "w-X.b-W-Y-Z-C-t",
   "correction": "off",
   "leans": [{"lean": "X+Y", "angle": "10um/m", "U": "4um/m"}],
   "in_force": [{"name": "EA0W", "angle": 1e-5}],
   "measurements": [{"by": "square", "move": "Z", "plunger": "+X",
     "at": [0, 300], "reads": "0:20um", "u": "1um"}]}

Only chain is necessary. The others are unit, reading, against, datum, travel, directions and frame, as the options of the
same names. A lean has lean or the name of a quantity; u is its standard uncertainty, U twice u. A measurement is by
square, diagonals, opening or points, with the fields of this option. Numbers are rad and mm; texts have a unit. correction is
necessary beside in_force.

The output repeats the document as input. --input takes the whole output, too, and prints it again. Its other keys:

  leans     each lean that the chain can have: both directions, the
            sign and the pin of each; measured, in_force and settled
            with U; before, words
  corrects  of a lean: the axis moved, the error, and its factor
  can_correct, why_not
            false if the lean alone corrects nothing on this chain
  corners   each two axes: basis, uncorrected, before, after, U, words
  settings  pins and values to set
  slopes, slopes_before
            travel of the tip for 1 of X, Y and Z, by the measured
            tilts alone, and with the angles in force

Errors name the place: machine.json: leans[1]: axis Y cannot lean towards -X and +X at once: choose one.)"},
         {"PICTURE",
          R"(Draw the machine with its leans, enlarged:

  plumb squareness --chain w-Z.b-X-Y-C-t --lean Y+X=60um/m \
    --directions X=left,Y=up,Z=back --picture machine.svg

Each axis has an arrow to its + end, a leaning axis a dashed one. --directions describes your machine: where the + ends point
as you stand before it. Two of the three are enough. The axes must be right-handed. The chain does not define
the frame: --frame column or --frame portal selects another one.)"},
         {"ERROR TABLES",
          R"(Check a file of error tables before the component reads it:

  plumb squareness --table errors.csv

This prints axes and rows, the machine, date and temperature in the head of the file, and its seal. A file without its last
line is refused, and the correct line is printed. squareness(9) describes the form of the file.

A damaged digit of an unsealed table moves the axes unseen. Seal each table:

  plumb squareness --table errors.csv --seal

This writes a checksum of the whole file into its last line. From then on, a changed or damaged file is refused. After you change
the file, check it, and seal it again. An editor may change the line ends and add or remove empty lines;
any other change, also of a remark, breaks the seal. --seal removes blanks at the ends of lines and a former checksum in the
head, and keeps owner and permissions of the file.

BACKLASH and COMP_FILE of LinuxCNC correct the scale of an axis, too. Check that no table repeats them:

  plumb squareness --table errors.csv --ini my.ini)"},
         {"EXIT STATUS",
          R"(0 after success; 1 if a file is refused, or a measurement contradicts a given tilt; 2 for a wrong command line.)"},
         {"EXAMPLES",
          R"(A column that leans:

  plumb squareness --chain w-Z.b-X-Y-C-t --lean Y+X=0.024mm/300mm \
    --lean Y+Z=60um/m

The same, by its quantities:

  plumb squareness --chain w-Z.b-X-Y-C-t --iso EC0Y=-80urad \
    --iso EA0Y=60urad

A table that moves in X and Y, with a square on it:

  plumb squareness --square move=Y,plunger=+X,at=0:300mm,reads=0:20um,u=1um

A column against the diagonals of a part, and, with a square that was turned, against Z as the datum:

  plumb squareness --chain w-Z.b-X-Y-C-t --datum X,Z,Y \
    --diagonals plane=XY,object=part,rising=565.708mm,falling=565.662mm,u=1um \
    --square move=Y,plunger=+Z,at=0:300mm,reads=0:20um,turned=0:-16um,u=1um)"},
         {"LIMITS",
          R"(A measurement of two axes gives the angle between them only. Drift after the measurement, straightness and
bending need error tables or a new measurement.)"}},
        ".BR plumb (1),\n.BR squareness (9),\n.BR plumb\\-bench (1),\n.BR halcmd (1)"};
}

}  // namespace plumb::commissioning
