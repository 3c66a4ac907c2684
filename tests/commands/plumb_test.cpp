// SPDX-License-Identifier: GPL-2.0-or-later
// `plumb` itself, and what all programs say of their command lines.
#include "tests/support/place.hpp"
#include "tests/support/program.hpp"

#include <gmock/gmock.h>

#include <string>

namespace plumb {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

TEST(Plumb, AnUnknownCommandIsNamedWithTheNearestAndAll) {
    const Outcome outcome = run_program({build_folder() + "/bin/plumb", "bech"}, "/");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.errors, AllOf(HasSubstr("there is no command 'bech'; did you mean 'bench'?"),
                                      HasSubstr("bench, commission, contacts, doctor, example, growth, "
                                                "panel, run, squareness, volume, wire")));
}

TEST(Plumb, AnUnknownCommandThatResemblesNoneHasNoGuess) {
    const Outcome outcome = run_program({build_folder() + "/bin/plumb", "photograph"}, "/");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.errors, AllOf(HasSubstr("'photograph'. There are"), Not(HasSubstr("did you mean"))));
}

TEST(Plumb, AnUnknownOptionIsBlamedAndNotItsValue) {
    const Outcome bench = run_program({build_folder() + "/bin/plumb", "bench", "--fro", "1h", "x.hal"}, "/");
    EXPECT_EQ(bench.status, 2);
    EXPECT_THAT(bench.errors, HasSubstr("plumb bench: there is no option --fro; did you mean '--for'?"));
    const Outcome run = run_program({build_folder() + "/bin/plumb", "run", "true", "--fro"}, "/");
    EXPECT_THAT(run.errors, Not(HasSubstr("there is no option")));  // of the program, which may have it
}

TEST(Plumb, HelpOfRunShowsTheProgram) {
    const Outcome outcome = run_program({build_folder() + "/bin/plumb", "run", "--help"}, "/");
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.output, HasSubstr("Usage: plumb run [OPTIONS] [--] PROGRAM [argument ...]\n"));
}

TEST(Plumb, HelpOfHalProgramsIsPlain) {
    const Outcome outcome = run_program({build_folder() + "/bin/plumb-retain", "--help"}, "/");
    EXPECT_EQ(outcome.status, 0);
    EXPECT_THAT(outcome.output, AllOf(HasSubstr("--period S "), HasSubstr("The default is 0.1."),
                                      Not(HasSubstr("FLOAT")), Not(HasSubstr("TEXT"))));
}

}  // namespace
}  // namespace plumb
