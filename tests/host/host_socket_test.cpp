// SPDX-License-Identifier: GPL-2.0-or-later
// The socket of root's host, on a computer with other users: they cannot put their own in its place, and a
// client does not speak to them.
#include "tests/support/bench.hpp"
#include "tests/support/machine.hpp"
#include "tests/support/place.hpp"
#include "tests/support/program.hpp"

#include <gmock/gmock.h>

#include <sys/shm.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <stdexcept>

namespace plumb {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

// A machine of root's on which there are other users.
struct HostSocket : testing::Test {
    void SetUp() override {
        if (geteuid() != 0) GTEST_SKIP() << "only root is more than one user";
    }
    static client::Start on_machine_start(bool namespaces = true) {
        client::Start start;
        start.executable = host_of_machine;
        start.namespaces = namespaces;
        return start;
    }
};

struct stat state_of(const std::filesystem::path& file) {
    struct stat state {};
    EXPECT_EQ(lstat(file.c_str(), &state), 0) << file;
    return state;
}

TEST_F(HostSocket, ItsFolderIsRootsAndNobodyElseChangesIt) {
    on_own_machine([] {
        for (const bool namespaces : {true, false}) {
            client::Client host(on_machine_start(namespaces));
            host.command(
                "loadrt threads name1=servo-thread period1=1000000");  // LinuxCNC's rtapi_app gets through
            const std::filesystem::path socket = host.socket();
            const struct stat folder = state_of(socket.parent_path());
            EXPECT_EQ(folder.st_uid, 0u);
            EXPECT_EQ(folder.st_mode & 07777, 0711u);
            Child other(false, [&](Child&) {
                EXPECT_NE(unlink(socket.c_str()), 0);
                EXPECT_NE(rename(socket.c_str(), "/tmp/away"), 0);
                EXPECT_NE(rename(socket.parent_path().c_str(), "/tmp/away"), 0);
                EXPECT_NE(symlink("/tmp", (socket.parent_path() / "link").c_str()), 0);
                EXPECT_THROW(client::Client(client::Attach{socket}), std::runtime_error);
            });
            other.await_success();
            host.command("loadrt lowpass");
        }
        expect_nothing_left({});
    });
}

TEST_F(HostSocket, AFolderForItThatOthersCanWriteIsNotTaken) {
    on_own_machine([] {
        ASSERT_EQ(mkdir("/tmp/open", 0711), 0);
        setenv("TMPDIR", "/tmp/open", 1);
        const auto socket = [] { return client::Client(on_machine_start()).socket(); };
        EXPECT_THAT(socket(), StartsWith("/tmp/open/plumb-host-"));
        ASSERT_EQ(chmod("/tmp/open", 0777), 0);
        EXPECT_THAT(socket(), StartsWith("/tmp/plumb-host-"));
        ASSERT_EQ(chmod("/tmp/open", 01777), 0);
        EXPECT_THAT(socket(), StartsWith("/tmp/open/plumb-host-"));
        ASSERT_EQ(chown("/tmp/open", 65534, 65534), 0);  // who could rename files in it
        EXPECT_THAT(socket(), StartsWith("/tmp/plumb-host-"));
    });
}

// As pam_tmpdir gives it to root: LinuxCNC's rtapi_app, with the rights of another user, could not get in.
TEST_F(HostSocket, APrivateTmpdirIsNotTaken) {
    on_own_machine([] {
        ASSERT_EQ(mkdir("/tmp/private", 0700), 0);
        ASSERT_EQ(mkdir("/tmp/private/more", 0755), 0);
        setenv("TMPDIR", "/tmp/private/more", 1);
        client::Client host(on_machine_start());
        EXPECT_THAT(host.socket(), StartsWith("/tmp/plumb-host-"));
        host.command("loadrt threads name1=servo-thread period1=1000000");
    });
}

// The one HAL's shared memory has keys that everybody knows.
TEST_F(HostSocket, MemoryThatAStrangerHasMadeIsNotUsed) {
    on_own_machine([] {
        constexpr int streamer_key = 0x48535430;
        Child other(false, [](Child&) { EXPECT_GE(shmget(streamer_key, 1000, IPC_CREAT | 0666), 0); });
        other.await_success();
        client::Client host(on_machine_start(false));
        try {
            host.command("loadrt streamer depth=10 cfg=f");
            ADD_FAILURE() << "it uses the memory of a stranger";
        } catch (const std::runtime_error& refusal) {
            EXPECT_THAT(refusal.what(), HasSubstr("shared memory 0x48535430 is user 65534's"));
        }
        ASSERT_EQ(shmctl(shmget(streamer_key, 0, 0), IPC_RMID, nullptr), 0);
        host.command("loadrt streamer depth=10 cfg=f");
    });
}

TEST_F(HostSocket, AClientDoesNotSpeakToAStranger) {
    on_own_machine([] {
        Child stranger(false, [](Child& self) {
            sockaddr_un address{AF_UNIX, "/tmp/socket"};
            const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
            ASSERT_EQ(bind(listener, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
            ASSERT_EQ(listen(listener, 8), 0);
            self.say("listens");
            self.await_go();
        });
        stranger.hear();
        try {
            client::Client client(client::Attach{"/tmp/socket"});
            ADD_FAILURE() << "it speaks to a stranger";
        } catch (const std::runtime_error& refusal) {
            EXPECT_STREQ(refusal.what(), "/tmp/socket belongs to user 65534, and is no host of yours");
        }
        setenv("PYTHONPATH", (build_folder() + "/python").c_str(), 1);
        const Outcome python =
            run_program({"/usr/bin/python3", "-c", "import plumb; plumb.Host(attach='/tmp/socket')"}, "/");
        EXPECT_NE(python.status, 0);
        EXPECT_THAT(python.errors, HasSubstr("/tmp/socket belongs to user 65534, and is no host of yours"));
        stranger.go();
        stranger.await_success();
    });
}

}  // namespace
}  // namespace plumb
