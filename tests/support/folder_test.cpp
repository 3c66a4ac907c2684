// SPDX-License-Identifier: GPL-2.0-or-later
// The folder of a test is one of hal/client/plumb_folder.py.
#include "tests/support/folder.hpp"
#include "tests/support/place.hpp"
#include "tests/support/program.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <optional>

namespace plumb {
namespace {

namespace fs = std::filesystem;

// Lets a program make a temporary folder of its own beside ours.
void let_the_next_program_begin() {
    const Outcome next = run_program({"/usr/bin/python3", "-c",
                                      "import sys; sys.path.insert(0, '" + build_folder() +
                                          "/python');"
                                          "import plumb_folder; plumb_folder.TemporaryFolder(sys.argv[1])",
                                      fs::temp_directory_path().string()},
                                     "/");
    ASSERT_EQ(next.status, 0) << next.output;
}

TEST(TestFolder, LivesBesideOtherProgramsAndEndsWithItsBlock) {
    std::optional<Folder> folder(std::in_place);
    folder->write("file", "text");
    let_the_next_program_begin();
    EXPECT_EQ(contents(*folder / "file"), "text");
    const fs::path path = folder->path();
    folder.reset();
    EXPECT_FALSE(fs::exists(path));
}

TEST(TestFolder, IsRemovedByTheNextProgramIfTheTestWasKilled) {
    const Folder note;
    const pid_t test = fork();
    if (test == 0) {
        const Folder folder;
        folder.write("file", "text");
        note.write("path", folder.path());
        _exit(0);  // without its destructor
    }
    ASSERT_EQ(waitpid(test, nullptr, 0), test);
    const fs::path path = contents(note / "path");
    ASSERT_TRUE(fs::exists(path / "file")) << path;
    let_the_next_program_begin();
    EXPECT_FALSE(fs::exists(path));
}

}  // namespace
}  // namespace plumb
