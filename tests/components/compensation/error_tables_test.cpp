// SPDX-License-Identifier: GPL-2.0-or-later
// Error tables that one thread reads while another uses them.
#include "components/compensation/squareness/squareness_model.hpp"

#include "components/io/files/error_table_seal.hpp"
#include "tests/support/error_table_text.hpp"
#include "tests/support/folder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>

namespace plumb {
namespace {

const AxisChain column = AxisChainReader::read("w-Z.b-X-Y-C-t");

// Both rows hold the same number, and both axes do: a set that is half another one shows.
std::string all_are(double number) {
    const std::string value = std::to_string(number);
    std::string text;
    for (const std::string axis : {"X", "Y"})
        text += axis + ",EX" + axis + "\n0," + value + "\n100," + value + "\n";
    return closed(text);
}

double of(const ErrorTables::Set& set, std::size_t axis) {
    return set[axis]->at(50).errors[0];
}

TEST(ErrorTables, ThatAreAskedForWhileTheyAreReadAreReadOnceMore) {
    const Folder folder;
    const std::string file = folder.write("xy.csv", all_are(0.001));
    ErrorTables tables;
    tables.load(file, column);

    folder.write("xy.csv", all_are(0.002));
    tables.ask();
    EXPECT_FALSE(tables.take_over());
    tables.ask();  // the first is on its way
    EXPECT_FALSE(tables.take_over());
    EXPECT_EQ(tables.work(), "");
    EXPECT_EQ(of(tables.in_use(), 0), 0.001);
    EXPECT_TRUE(tables.take_over());
    EXPECT_EQ(of(tables.in_use(), 0), 0.002);
    EXPECT_EQ(of(tables.before(), 0), 0.001);

    folder.write("xy.csv", all_are(0.003));
    EXPECT_EQ(tables.work(), "");
    EXPECT_EQ(of(tables.before(), 0), 0.001) << "read in the period of the take-over";
    EXPECT_FALSE(tables.take_over());
    EXPECT_EQ(tables.work(), "");
    EXPECT_TRUE(tables.take_over());
    EXPECT_EQ(of(tables.in_use(), 1), 0.003);

    EXPECT_FALSE(tables.take_over());
    EXPECT_EQ(tables.work(), "");
    EXPECT_FALSE(tables.take_over()) << "nobody asked";
}

TEST(ErrorTables, EachUnsealedFileIsNamedOnceWithTheCommandThatSealsIt) {
    const Folder folder;
    const std::string file = folder.write("xy.csv", all_are(0.001));
    const std::string advice = file +
                               " has no seal, so a damaged digit can go unseen: check the table, then: "
                               "plumb squareness --table " +
                               file + " --seal";
    ErrorTables tables;
    tables.load(file, column);
    EXPECT_THAT(tables.take_facts(), testing::ElementsAre(testing::EndsWith(", no seal"), advice));
    const auto read_again = [&] {
        tables.take_over();
        tables.ask();
        tables.take_over();
        const std::string reason = tables.work();
        tables.take_over();
        return reason;
    };
    EXPECT_EQ(read_again(), "");
    EXPECT_THAT(tables.take_facts(), testing::ElementsAre(testing::EndsWith(", no seal")));

    seal_error_table(file);
    EXPECT_EQ(read_again(), "");
    EXPECT_THAT(tables.take_facts(), testing::ElementsAre(testing::HasSubstr(", seal ")));
    std::string damaged = contents(file);
    damaged.replace(damaged.find("0.001"), 5, "0.003");
    folder.write("xy.csv", damaged);
    EXPECT_THAT(read_again(),
                testing::HasSubstr("check it, then: plumb squareness --table " + file + " --seal"));
    EXPECT_TRUE(tables.refused());
    EXPECT_EQ(of(tables.in_use(), 0), 0.001) << "the tables of before stay";

    folder.write("xy.csv", all_are(0.002));
    EXPECT_EQ(read_again(), "");
    EXPECT_THAT(tables.take_facts(), testing::ElementsAre(testing::EndsWith(", no seal"), advice));
}

TEST(ErrorTables, InUseAreWholeWhileOthersAreRead) {
    const Folder folder;
    const std::string file = folder.write("xy.csv", all_are(0.001));
    ErrorTables tables;
    tables.load(file, column);
    std::atomic<bool> over{false};
    std::thread reader([&] {
        for (int n = 0; !over; ++n) {
            folder.write("xy.csv", all_are(n % 9 * 0.001));
            EXPECT_EQ(tables.work(), "");
        }
    });
    int taken = 0;
    for (int asked = 0; taken < 50; ++asked) {
        if (asked % 3 == 0) tables.ask();
        const bool others = tables.take_over();
        taken += others;
        for (const ErrorTables::Set* set : {&tables.in_use(), others ? &tables.before() : &tables.in_use()})
            EXPECT_EQ(of(*set, 0), of(*set, 1));
        std::this_thread::yield();
    }
    over = true;
    reader.join();
}

}  // namespace
}  // namespace plumb
