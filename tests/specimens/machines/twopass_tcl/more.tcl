# SPDX-License-Identifier: GPL-2.0-or-later
loadrt sum2 names=watch
addf watch servo-thread
net xt joint.0.pos-cmd => watch.in0
