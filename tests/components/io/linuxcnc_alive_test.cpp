// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/linuxcnc_alive/beat.hpp"
#include "components/io/linuxcnc_alive/process_wakes.hpp"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <optional>
#include <thread>

namespace plumb {
namespace {

// A process that does the work again and again, until the end of the test.
class Child {
public:
    template <class Work>
    explicit Child(Work work) : process(fork()) {
        if (process == 0)
            for (;;) work();
    }
    ~Child() { end(); }

    void stop() const {
        kill(process, SIGSTOP);
        int status = 0;
        waitpid(process, &status, WUNTRACED);
    }
    void await_death() const {
        siginfo_t info{};
        waitid(P_PID, static_cast<id_t>(process), &info, WEXITED | WNOWAIT);
    }
    void end() {
        if (ended_) return;
        ended_ = true;
        kill(process, SIGKILL);
        waitpid(process, nullptr, 0);
    }

    const pid_t process;

private:
    bool ended_ = false;
};

void wait() {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

// By how much the count grows in a while that is long for the loops here.
std::uint64_t growth(const ProcessWakes& wakes) {
    const auto before = wakes.count();
    wait();
    const auto after = wakes.count();
    return after.value() - before.value();
}

TEST(ProcessWakes, GrowAsLongAsAProcessSleepsInALoop) {
    Child child([] { usleep(2000); });
    const ProcessWakes wakes(child.process);
    wait();
    EXPECT_GT(growth(wakes), 3u);
    child.stop();
    EXPECT_EQ(growth(wakes), 0u);
    kill(child.process, SIGCONT);
    wait();
    EXPECT_GT(growth(wakes), 3u);
    kill(child.process, SIGKILL);
    child.await_death();
    EXPECT_EQ(growth(wakes), 0u);  // nobody has asked for its status
    child.end();
    EXPECT_EQ(wakes.count(), std::nullopt);
}

TEST(ProcessWakes, StandStillInALoopWithoutSleepAndInAWaitWithoutEnd) {
    Child busy([] {});
    Child waiting([] { pause(); });
    wait();
    EXPECT_EQ(growth(ProcessWakes(busy.process)), 0u);
    EXPECT_EQ(growth(ProcessWakes(waiting.process)), 0u);
}

TEST(ProcessWakes, AreNothingForAProcessThatNeverWas) {
    EXPECT_EQ(ProcessWakes(0).count(), std::nullopt);
}

TEST(Beat, SeesEachAdvanceAndMeasuresThePauses) {
    Beat beat;
    EXPECT_FALSE(beat.see(std::nullopt, 0));
    EXPECT_FALSE(beat.see(7, 10));
    EXPECT_FALSE(beat.see(7, 20));  // it has not advanced yet
    EXPECT_EQ(beat.longest_pause(), 0);
    EXPECT_TRUE(beat.see(8, 21));
    EXPECT_FALSE(beat.see(8, 22));
    EXPECT_TRUE(beat.see(12, 24));
    EXPECT_EQ(beat.longest_pause(), 3);
    EXPECT_FALSE(beat.see(std::nullopt, 29));  // a pause that goes on counts
    EXPECT_EQ(beat.longest_pause(), 5);
    EXPECT_FALSE(beat.see(12, 30));
    EXPECT_TRUE(beat.see(3, 31));  // the program has begun again
    EXPECT_EQ(beat.longest_pause(), 7);
}

}  // namespace
}  // namespace plumb
