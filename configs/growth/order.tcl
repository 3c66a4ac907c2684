# SPDX-License-Identifier: GPL-2.0-or-later
# Written by plumb wire. The last HALFILE: it adds functions in front of motion-controller and behind it, in this order.

proc plumb_order {before behind} {
  if {[info procs ::tp::passnumber] ne "" && [::tp::passnumber] == 0} return    ;# TWOPASS adds functions in its second pass
  foreach line [split [exec halcmd -s show thread] \n] {    ;# a file that loads a function may have added it
    foreach name [concat $before $behind] {
      if {[lsearch -exact $line $name] >= 0} {
        delf $name [lindex $line 2]
      }
    }
  }
  foreach line [split [exec halcmd -s show thread] \n] {
    set found [lsearch -exact $line motion-controller]
    if {$found < 0} continue
    set thread [lindex $line 2]
    set place [expr {$found - 4}]    ;# the first function of a thread is the sixth word of its line
    foreach name $before {
      addf $name $thread $place
      incr place
    }
    foreach name $behind {
      incr place
      addf $name $thread $place
    }
    return
  }
  error "no thread has motion-controller: the HALFILE that adds it must come before this one"
}

plumb_order {

} {
  growth-test.update
  interlock.update
}
