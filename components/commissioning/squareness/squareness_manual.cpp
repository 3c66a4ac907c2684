// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/squareness/squareness_manual.hpp"

namespace plumb::commissioning {

hal::CommandPage squareness_page() {
    return {
        "plumb-squareness",
        "[--chain CHAIN] [tilts or measurements] [options]",
        {{"DESCRIPTION",
          R"(Turns what is known of the tilted axes of a machine into the settings of the component squareness. Known
is either how the axes lean and by how much, or the quantities of ISO 230-1, or what was measured with diagonals,
with square and indicator, or with a probe. In each case it prints all that belongs together: the chain of axes; the
direction in which each axis leans; the angle in rad, arcsec, deg and as length per length; and the
quantity of ISO 230-1 with its sign. Then come the lines for the .hal file, and for each pair of axes the one
move that shows, with square and indicator, whether the sign is right.

Without tilts and measurements it prints those that the chain can have.

An ANGLE is a number with a unit, rad, mrad, urad, deg, arcmin or arcsec, or a length per length: 60um/m, 0.06mm/m,
0.02mm/300mm, 0.001in/ft, 0.02/300. A LENGTH is a number with um, mm, cm, m, in, ft or thou. Numbers have a decimal
point.)"},
         {"SIGNS",
          R"(An axis leans towards D where its + end is off towards D. For an axis that carries the work that is the end
to which the tool goes, seen from the work; for a ram it is the end away from its nose. Of each line an axis leans to
one end only; both are refused.

  axis  leans to  is        axis  leans to  is        axis  leans to  is
  Y, V  +X        EC0Y -    Z, W  +X        EB0Z +    X, U  +Y        EC0X +
  Y, V  -X        EC0Y +    Z, W  -X        EB0Z -    X, U  -Y        EC0X -
  Y, V  +Z        EA0Y +    Z, W  +Y        EA0Z -    X, U  +Z        EB0X -
  Y, V  -Z        EA0Y -    Z, W  -Y        EA0Z +    X, U  -Z        EB0X +

A is about X, B about Y, C about Z, positive as a right hand turns: +C takes +X towards +Y. The last letter is that of the
axis: EC0V.)"},
         {"MEASURING",
          R"(A measurement tells by how much the angle between the + ends of two axes is more or less than 90 deg. As in
ISO 230-1, one of the two is the datum, and the other one leans: of X and Y it is Y, by EC0Y, unless --datum says
otherwise. Where one axis carries another, it turns that as well, as --reading and --against say; this is taken off. So one
measurement may give two angles, and an angle may follow from two. If the datum itself is known to lean, by --lean or --iso,
the other one is held against it as it leans.

A square sees the corner of two axes, not which of them leans. Where one carries the other, as Y carries X on the
table of w-X-Y.b-Z-C-t, a lean of Y takes X along, and the corner stays as it is. So give what a square or diagonals showed as a
measurement, not by --lean.

Measure with the correction off, on a machine that has settled. Otherwise the result is what the correction has
left. A tilt holds for the travel over which it was measured: choose that of the work. Straightness enters into it.

Each measurement is a list of fields, KEY=VALUE,KEY=VALUE, without blanks. In all of them

  u=LENGTH         is the standard uncertainty of a single reading; or U=LENGTH is twice that
  own-u=ANGLE      is that of the artifact or square itself; without it, it is taken as true
  object=part      says that these axes have drawn the shape: they cut the part, or moved along a
                   path that a laser or a ballbar measured
  object=artifact  says that the shape is true, and that a probe on these axes measured it

The object decides over the sign: a part that is longer along a diagonal comes from axes to which an artifact seems shorter there.

Several measurements of the same two axes become their weighted mean. Where readings scatter more than was
stated, the uncertainty is widened by as much; it is never narrowed. own-u does not become less by repeating: it counts as
that of one square or artifact. So state u honestly: of a few readings the scatter says
little.)"},
         {"DIAGONALS",
          R"(Of a square or rectangle whose sides lie along the axes:

  --diagonals plane=XY,object=part,rising=565.709mm,falling=565.662mm,u=1um

rising is the diagonal from the corner at both - ends to the one at both + ends, falling the
other. Of a rectangle also sides=400:300mm, the first along the first axis of the plane. Of an artifact that is known to be
out of square also own=ANGLE, by which its corner at both - ends is more than 90 deg.)"},
         {"SQUARE AND INDICATOR",
          R"(Readings of the same leg at two heights, or at more places along a travel:

  --square move=Y,plunger=+X,at=0:300mm,reads=0:24um,turned=0:-20um,u=1um

One leg of the square lies along an axis, here X, trued by moving that. An indicator on the tool's side touches the other leg as
the axis move, here Y, runs along it. plunger is the direction in which its plunger points; at the positions of the axis; reads
what it reads there, more as the plunger is pressed in.

turned is read after turning the square by half a turn about the leg that is touched: touch the same face, now from
the other side, with the plunger pointing the other way, at the same positions. This cancels the square's own error.

Two readings are enough, more are better. Of a list without units, the last value has the unit for all.)"},
         {"PROBED POINTS",
          R"(Points on the faces of a square or polygon, or around a ring:

  --points file=square.csv,object=artifact,u=0.5um

unit=in if they are not in mm. The file's header names
its columns: the two axes of the plane; normal, the direction in which the face looks, in deg from the + end of the axis that
comes first in XYZUVW towards that of the other; and turned, by how many deg the artifact was turned before,
likewise. Without normal it is a ring. Lines that begin with # say nothing.

  X,Y,normal,turned
  152.013,-120.5,0,0
  152.010,120.5,0,0
  -120.5,151.998,90,0
  120.5,152.021,90,0

A program of LinuxCNC writes such a file with (LOGOPEN,square.csv), (LOG,X,Y,normal,turned), and (LOG,#5061,#5062,0,0) after each
G38.2 onto a face that looks to +X.

It takes two points on each of two faces that are neither parallel nor at 45 deg to the axes, or five around a ring; better many.
They need not be corrected for the ball of the probe. Probe the artifact again after turning it by 90 deg, and its own error is
told from that of the axes. own-u is an ANGLE, of the direction of a face; of a ring a LENGTH, of its ovality.)"},
         {"ERROR TABLES",
          R"(Before the component reads a file of error tables, see whether it is whole, and which machine it is of:

  plumb squareness --table errors.csv

prints axes and rows, the machine, date and temperature that the head of the file states, and the checksum of the rows. A
file without its last line, or with a checksum that is not that of its rows, is refused, and the right line is printed.
squareness(9) has the form of the file.)"},
         {"EXIT STATUS",
          R"(0 after success; 1 where a file cannot be taken, or what was measured contradicts what was set; 2 for a wrong
command line.)"},
         {"EXAMPLES",
          R"(A column that leans, as a square and an indicator tell:

  plumb squareness --chain w-Z.b-X-Y-C-t --lean Y+X=0.024mm/300mm --lean Y+Z=60um/m

The same, by its quantities:

  plumb squareness --chain w-Z.b-X-Y-C-t --iso EC0Y=-80urad --iso EA0Y=60urad

A table that moves in X and Y, with a square on it:

  plumb squareness --square move=Y,plunger=+X,at=0:300mm,reads=0:20um,u=1um

A column against the diagonals of a part, and, with a square that was turned, against Z as the datum:

  plumb squareness --chain w-Z.b-X-Y-C-t --datum X,Z,Y \
    --diagonals plane=XY,object=part,rising=565.708mm,falling=565.662mm,u=1um \
    --square move=Y,plunger=+Z,at=0:300mm,reads=0:20um,turned=0:-16um,u=1um)"}},
        ".BR plumb (1),\n.BR squareness (9),\n.BR plumb\\-bench (1),\n.BR halcmd (1)"};
}

}  // namespace plumb::commissioning
