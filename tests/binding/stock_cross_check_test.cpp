// SPDX-License-Identifier: GPL-2.0-or-later
// The virtual-time host computes the same as the machine would, to the last bit.
#include "tests/support/stock_cross_check.hpp"
#include "tests/support/place.hpp"

#include "tests/support/bench.hpp"

namespace plumb {
namespace {

#ifndef PLUMB_SANITIZED  // stock LinuxCNC is not built with sanitizers

TEST(StockCrossCheck, StockModulesComputeTheSameInBoth) {
    const Folder folder;
    const auto file = folder.write("loop.hal", R"(loadrt threads name1=servo-thread period1=1000000
loadrt siggen  names=wave
loadrt limit3  names=limit
loadrt lowpass names=filter
loadrt pid     names=loop
loadrt scale   names=scale
loadrt near    names=near
setp wave.frequency 0.7310585
setp limit.maxv     2
setp limit.maxa     30
setp filter.gain    0.03
setp loop.Pgain     3
setp loop.Igain     7
setp loop.Dgain     0.01
setp loop.enable    1
setp scale.gain     -1.7
setp near.difference 0.05
net wanted   wave.sine  => limit.in near.in1
net possible limit.out  => loop.command near.in2
net moved    filter.out => loop.feedback
net driven   loop.output => filter.in scale.in
addf wave.update         servo-thread
addf limit               servo-thread
addf loop.do-pid-calcs   servo-thread
addf filter              servo-thread
addf scale               servo-thread
addf near                servo-thread
start
)");
    expect_same_records(
        file, {"wanted", "limit.out", "filter.out", "driven", "scale.out", "loop.error", "near.out"}, 3);
}

TEST(StockCrossCheck, TheMillsBenchComputesTheSameInBoth) {
    expect_same_records(source_folder() + "/configs/mill/bench.hal",
                        {"program.z-position-cmd", "mill.z-position", "drive.load", "mill.truth-growth"}, 10);
}

#endif

}  // namespace
}  // namespace plumb
