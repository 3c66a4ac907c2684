# SPDX-License-Identifier: GPL-2.0-or-later
# HAL in Tcl, with the same commands.
loadrt threads name1=servo period1=1000000
loadrt or2 count=3
for {set i 0} {$i < 3} {incr i} {
    addf or2.$i servo
    setp or2.$i.in0 [expr $i % 2]
    net out-$i or2.$i.out
}
net out-0 => or2.1.in1
start
hal loadusr -w ./wait_for.py or2.1.out 1 60
puts [hal getp or2.1.out]
puts [hal gets out-2]
puts [hal list sig]
puts [catch {setp nothing 1} said]
puts $said
puts [hal save thread]
