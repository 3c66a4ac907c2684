# SPDX-License-Identifier: GPL-2.0-or-later
# plumb_order BEFORE BEHIND, for a HALFILE in Tcl: it adds functions in front of motion-controller and behind it, in the thread that
# has it. order.tcl of plumb wire takes this file from LinuxCNC's hallib, where the package installs it, or else from its own folder.

proc plumb_threads {} {    ;# a list for each thread: its name and its functions
  set threads {}
  foreach line [split [exec halcmd -s show thread] \n] {
    if {[llength $line] == 1} {    ;# LinuxCNC 2.10 shows each function on a line of its own
      lset threads end [concat [lindex $threads end] $line]
    } elseif {[llength $line] > 1} {
      lappend threads [concat [lindex $line 2] [lrange $line 5 end]]
    }
  }
  return $threads
}

proc plumb_order {before behind} {
  if {[info procs ::tp::passnumber] ne "" && [::tp::passnumber] == 0} return    ;# TWOPASS adds functions in its second pass
  foreach functions [plumb_threads] {    ;# a file that loads a function may have added it
    set thread [lindex $functions 0]
    foreach name [concat $before $behind] {
      if {[lsearch -exact [lrange $functions 1 end] $name] >= 0} {
        delf $name $thread
      }
    }
  }
  foreach functions [plumb_threads] {
    set place [lsearch -exact $functions motion-controller]
    if {$place < 0} continue
    set thread [lindex $functions 0]
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
