# SPDX-License-Identifier: GPL-2.0-or-later
# Written by plumb wire. The last HALFILE: it adds functions in front of motion-controller and behind it, in this order.

# The installed package gives plumb_order.tcl; without the package, the copy in a folder here does.
if {[catch {source $::env(HALLIB_DIR)/plumb_order.tcl}]} {source [file join [file dirname [info script]] functions/plumb_order.tcl]}

plumb_order {
  x-stage.update-feedback
  z-stage.update-feedback
} {
  chop.update
  x-stage.update
  z-stage.update
  interlock.update
}
