// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/files/growth_log_file.hpp"

#include "components/io/growth_log/growth_log_writer.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/refusal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>

namespace plumb {
namespace {

using growth_log_file::identity_of;
using testing::HasSubstr;

const std::string without_checksums =
    "growth-log,2\nlog,7\nmachine,mill 3\nbegun,2026-11-22T19:59:18Z\nunit,1\nball,6\ntable,B\n"
    "tolerance,0.01,0.01,0.015\nwarming,spindle\ncompensation,none\nsensor,1,spindle\n"
    "artifact,1,11.5,1,0,-100,2\nbore,1,0,-60,60\n"
    "event,1,0,0,0,0,0,0,0,begin,0\ntemperature,2,0,1,19.742242739517245,1,2.8\n"
    "touch,3,4.4,1,1,1,0,0,0,-Z,25.1,-60.02,-137.005,0,0,0\nspeed,4,5,12000\n";

std::string checked(const std::string& text) {
    return LineChecksums().added(text);
}

std::string with_line_ends(const std::string& text, const std::string& end) {
    std::string result;
    for (const char c : text) result += c == '\n' ? end : std::string(1, c);
    return result;
}

std::string refusal(const std::string& text) {
    return plumb::refusal<std::runtime_error>([&] { growth_log_file::parse(text, "/a.csv"); });
}

std::string flipped(std::string text, std::size_t bit) {
    text[bit / 8] = static_cast<char>(text[bit / 8] ^ 1 << bit % 8);
    return text;
}

TEST(GrowthLogFile, NoFlippedBitIsTaken) {
    for (const char* const end : {"\n", "\r\n"}) {
        const std::string whole = with_line_ends(checked(without_checksums), end);
        ASSERT_EQ(refusal(whole), "accepted");
        for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit)
            EXPECT_NE(refusal(flipped(whole, bit)), "accepted")
                << "bit " << bit % 8 << " of byte " << bit / 8 << " of " << whole;
    }
}

TEST(GrowthLogFile, AChecksumIsThatOfZipOverTheLinesSoFar) {
    EXPECT_EQ(LineChecksums().added("growth-log,2\nlog,7\n"), "growth-log,2,9d40ea97\nlog,7,3e3a3d11\n");
    const GrowthLog log = growth_log_file::parse(checked(without_checksums), "/a.csv");
    EXPECT_EQ(log.number, 7);
    EXPECT_EQ(log.records.size(), 4u);
    EXPECT_EQ(log.records[2].at[2], -137.005);
}

TEST(GrowthLogFile, ADamagedLineIsNamedAndTheLinesBeforeItAreWhole) {
    const std::string whole = checked(without_checksums);
    std::string damaged = whole;
    damaged.replace(damaged.find("25.1"), 4, "25.7");
    EXPECT_EQ(refusal(damaged),
              "/a.csv:16: does not fit its checksum: it was changed or is damaged; the lines before it are "
              "whole: head -n 15");
    EXPECT_EQ(refusal(damaged.substr(0, damaged.find("touch"))), "accepted");
    const std::size_t second = whole.find("bore"), third = whole.find("event");
    EXPECT_THAT(refusal(whole.substr(0, second) + whole.substr(third)), HasSubstr("/a.csv:13: does not fit"));
    EXPECT_THAT(refusal(whole + whole), HasSubstr("/a.csv:18: does not fit"));
    EXPECT_THAT(refusal(without_checksums), HasSubstr("/a.csv:1: has no checksum"));
}

TEST(GrowthLogFile, OtherVersionsAreRefused) {
    std::string text = without_checksums;
    text.replace(text.find('2'), 1, "1");
    EXPECT_TRUE(identity_of(text).damaged);
    EXPECT_THAT(refusal(checked(text)), HasSubstr("/a.csv:1: is of version '1'"));
}

TEST(GrowthLogFile, NoFlippedBitGivesItAnotherNumber) {
    const std::string whole = checked(without_checksums),
                      start = whole.substr(0, growth_log_file::identity_bytes);
    EXPECT_EQ(identity_of(start).number, 7);
    EXPECT_FALSE(identity_of(start).damaged);
    for (std::size_t bit = 0; bit < 8 * (whole.find("machine") - 1); ++bit)
        EXPECT_TRUE(identity_of(flipped(start, bit)).damaged) << "bit " << bit;
    for (std::size_t length = 0; length < whole.find("machine"); ++length) {
        EXPECT_EQ(identity_of(start.substr(0, length)).number, 0) << "its test had not begun";
        EXPECT_FALSE(identity_of(start.substr(0, length)).damaged) << length;
    }
    EXPECT_TRUE(identity_of(std::string(64, 'x')).damaged);
}

GrowthLog head_of(const std::string& machine) {
    GrowthLog head;
    head.machine = machine;
    return head;
}

GrowthRecord begin_record() {
    GrowthRecord r;
    r.kind = GrowthRecord::event;
    r.item = 1;
    return r;
}

// A log of a test that has begun.
std::string log_in(const Folder& folder) {
    GrowthLogWriter writer(folder.path());
    writer.begin(head_of("mill"));
    writer.append(growth_log_file::line(begin_record(), 1));
    return writer.path().string();
}

std::string refusal_in(const Folder& folder) {
    return plumb::refusal<std::runtime_error>([&] { GrowthLogWriter(folder.path()).unfinished(); });
}

TEST(GrowthLogWriter, LogsAreKnownByTheNumberInThemAndNotByNameOrTime) {
    const Folder folder;
    const std::string first = log_in(folder);
    std::filesystem::rename(first, folder / "growth-20991231-235959.csv");
    const std::string second = log_in(folder);
    std::filesystem::last_write_time(
        second, std::filesystem::file_time_type::clock::now() - std::chrono::hours(9999));
    EXPECT_EQ(GrowthLogWriter(folder.path()).unfinished()->file, second);
    EXPECT_EQ(GrowthLogWriter(folder.path()).unfinished()->number, 2);
}

TEST(GrowthLogWriter, NothingIsResumedWhileTheLastLogIsNotKnown) {
    const Folder folder;
    const std::string first = log_in(folder), second = log_in(folder);
    std::filesystem::copy(second, folder / "growth-copy.csv");
    EXPECT_THAT(refusal_in(folder),
                HasSubstr(" have the same number, 2: move one of them out of the folder"));
    std::filesystem::remove(folder / "growth-copy.csv");
    EXPECT_EQ(refusal_in(folder), "accepted");

    std::string text = contents(first);
    text.replace(text.find("log,1"), 5, "log,9");
    folder.write(std::filesystem::path(first).filename(), text);
    EXPECT_EQ(refusal_in(folder),
              first +
                  ":2: does not fit its checksum: it was changed or is damaged; the lines "
                  "before it are whole: head -n 1");
    EXPECT_EQ(identity_of(contents(log_in(folder))).number, 10) << "no number is given twice";
    folder.write("growth-mine.csv", "time,temperature\n" + std::string(60, '1') + "\n");
    std::filesystem::remove(first);
    EXPECT_THAT(refusal_in(folder), HasSubstr("growth-mine.csv:1: is no growth log"));
}

TEST(GrowthLogWriter, ALogWithoutANumberIsTheLastOneOnlyIfItIsTheOnlyOne) {
    const Folder folder;
    const std::string text = checked("growth-log,2\nmachine,mill\nevent,1,0,0,0,0,0,0,0,begin,0\n");
    const std::string only = folder.write("growth-20260101-000000.csv", text);
    EXPECT_EQ(GrowthLogWriter(folder.path()).unfinished()->file, only);
    folder.write("growth-20990101-000000.csv", text);
    EXPECT_FALSE(GrowthLogWriter(folder.path()).unfinished().has_value());
    const std::string numbered = log_in(folder);
    EXPECT_EQ(GrowthLogWriter(folder.path()).unfinished()->file, numbered);
}

TEST(GrowthLogWriter, AResumedLogStaysOne) {
    const Folder folder;
    GrowthRecord next = begin_record();
    next.kind = GrowthRecord::speed;
    next.time = 3;
    log_in(folder);
    GrowthLogWriter writer(folder.path());
    const GrowthLog log = *writer.unfinished();
    std::ofstream(log.file, std::ios::app) << "touch,2,";
    writer.resume(log);
    writer.append(growth_log_file::line(next, 2));
    const GrowthLog again = read_growth_log(log.file);
    EXPECT_EQ(again.records.size(), 2u);
    EXPECT_EQ(again.torn, "");
}

TEST(GrowthLogWriter, ALogThatWasDamagedSinceItWasReadIsNotResumed) {
    const Folder folder;
    const std::string file = log_in(folder);
    GrowthLogWriter writer(folder.path());
    const GrowthLog log = *writer.unfinished();
    std::string text = contents(file);
    text.replace(text.find("mill"), 4, "lathe");
    folder.write(std::filesystem::path(file).filename(), text);
    EXPECT_THROW(writer.resume(log), std::runtime_error);
    EXPECT_EQ(contents(file), text);
}

TEST(GrowthLogWriter, TheTimeSinceTheLastWriteComesFromNoClockThatIsSet) {
    const Folder folder;
    const std::string file = log_in(folder);
    for (const int hours : {-9999, 9999}) {
        std::filesystem::last_write_time(
            file, std::filesystem::file_time_type::clock::now() + std::chrono::hours(hours));
        const std::optional<double> time = GrowthLogWriter(folder.path()).since_last_write(1);
        ASSERT_TRUE(time.has_value());
        EXPECT_GE(*time, 0);
        EXPECT_LT(*time, 600);
    }
    EXPECT_FALSE(GrowthLogWriter(folder.path()).since_last_write(2).has_value()) << "of another log";
    const std::string note = contents(folder / ".growth_log.last");
    for (std::size_t bit = 0; bit < 8 * note.size(); ++bit) {
        folder.write(".growth_log.last", flipped(note, bit));
        EXPECT_FALSE(GrowthLogWriter(folder.path()).since_last_write(1).has_value()) << "bit " << bit;
    }
    std::string other_start = note.substr(0, note.rfind(' '));
    other_start[other_start.find(' ') + 1] ^= 1;  // the identity of the start of the computer
    char sum[12];
    std::snprintf(sum, sizeof sum, " %08x\n", static_cast<unsigned>(crc_32(other_start)));
    folder.write(".growth_log.last", other_start + sum);
    EXPECT_FALSE(GrowthLogWriter(folder.path()).since_last_write(1).has_value());
    std::filesystem::remove(folder / ".growth_log.last");
    EXPECT_FALSE(GrowthLogWriter(folder.path()).since_last_write(1).has_value());
}

}  // namespace
}  // namespace plumb
