# SPDX-License-Identifier: GPL-2.0-or-later
"""Touches of a reference that is fixed to the machine, for the axis_growth of a bench."""

SIGMA = 2  # um, of a touch


def touch(host, instance, grown, draw):
    """`grown`: by axis, the growth in um. Each touch has its noise."""
    for axis, growth in grown.items():
        offset = host.get("%s.%s-offset" % (instance, axis))
        host.set("%s.touched-position" % instance, 1e-3 * (growth + draw.gauss(0, SIGMA)) - offset)
        host.set("%s.touched-axis" % instance, "xyz".index(axis) + 1)
        host.run(1)
        host.set("%s.touched-axis" % instance, 0)
        host.run(1)
