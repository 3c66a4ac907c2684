// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/io/files/error_table_file.hpp"
#include "components/io/files/error_table_seal.hpp"

#include "tests/support/error_table_text.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/refusal.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sys/stat.h>
#include <unistd.h>

#include <clocale>
#include <filesystem>
#include <locale>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace plumb {
namespace {

using testing::ElementsAre;

using Texts = std::vector<std::pair<std::string, std::string>>;  // by name

std::map<char, DirectedErrorTable> tables_of(const Texts& texts) {
    error_table_file::Reader reader;
    for (const auto& [name, text] : texts) reader.read(name, text);
    return std::move(reader).tables();
}

ErrorMotions errors_of(char axis, const std::string& text, double position) {
    return tables_of({{"a.csv", closed(text)}}).at(axis).at(position).errors;
}

std::string refusal(const Texts& texts) {
    return plumb::refusal<std::runtime_error>([&] { tables_of(texts); });
}

std::string refusal(const std::string& text) {
    return refusal({{"/a.csv", text}});
}

TEST(ErrorTableFile, GivesEachErrorItsPlaceByItsName) {
    EXPECT_THAT(
        errors_of('Y', "Y,EXY,EYY,EZY,EAY,EBY,ECY\n0,1e-3,2e-3,3e-3,4e-6,5e-6,6e-6\n50,0,0,0,0,0,0\n", 0),
        ElementsAre(1e-3, 2e-3, 3e-3, 4e-6, 5e-6, 6e-6));
    EXPECT_THAT(
        errors_of('Y', "ECY,EAY,Y,EZY,EBY,EXY,EYY\n6e-6,4e-6,0,3e-3,5e-6,1e-3,2e-3\n0,0,50,0,0,0,0\n", 0),
        ElementsAre(1e-3, 2e-3, 3e-3, 4e-6, 5e-6, 6e-6));
}

TEST(ErrorTableFile, AnErrorWithoutColumnIsZero) {
    EXPECT_THAT(errors_of('W', "W,EBW\n-10,2e-5\n10,4e-5\n", -10), ElementsAre(0, 0, 0, 0, 2e-5, 0));
}

TEST(ErrorTableFile, EveryLinearAxisHasItsTable) {
    for (const char axis : std::string("XYZUVW")) {
        const std::string a(1, axis);
        EXPECT_THAT(errors_of(axis, a + ",EX" + a + ",EC" + a + "\n0,0.001,1e-6\n9,0,0\n", 0),
                    ElementsAre(0.001, 0, 0, 0, 0, 1e-6));
    }
}

TEST(ErrorTableFile, CommentsBlanksMarksAndLineEndsAreIgnored) {
    EXPECT_THAT(
        errors_of('X', "\xef\xbb\xbf# laser\r\n\r\n X , EXX\r\n# cold\r\n 0 , +0.001 \r\n\t10,-.5e-3", 0),
        ElementsAre(0.001, 0, 0, 0, 0, 0));
}

TEST(ErrorTableFile, TablesOfSeveralAxesComeInOneFileOrInSeveral) {
    const std::string x = "X,EXX\n0,0.001\n10,0\n", z = "Z,EZZ\n0,0.002\n20,0\n";
    for (const Texts& texts : {Texts{{"a", closed(x + z)}}, Texts{{"a", closed(x)}, {"b", closed(z)}}}) {
        const std::map<char, DirectedErrorTable> tables = tables_of(texts);
        ASSERT_EQ(tables.size(), 2u);
        EXPECT_EQ(tables.at('X').at(0).errors[0], 0.001);
        EXPECT_EQ(tables.at('Z').at(0).errors[2], 0.002);
    }
}

struct DecimalComma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
};

TEST(ErrorTableFile, ADecimalPointIsAPointInEveryLocale) {
    const std::string before = std::setlocale(LC_ALL, nullptr);
    const std::locale streams = std::locale::global(std::locale(std::locale(), new DecimalComma));
    std::setlocale(LC_ALL, "de_DE.UTF-8");  // of C, where it is installed
    EXPECT_EQ(errors_of('X', "X,EXX\n0,0.0015\n10,0\n", 0)[0], 0.0015);
    EXPECT_EQ(refusal("X,EXX\n0,0\n1.5,10.5\n"),
              "/a.csv: line 3: column EXX: '10.5' is beyond 10 mm; is it in mm?");
    std::locale::global(streams);
    std::setlocale(LC_ALL, before.c_str());
}

TEST(ErrorTableFile, RefusesAHeaderWithItsReason) {
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"", "/a.csv: there is no table in it"},
        {"# nothing\n\n", "/a.csv: there is no table in it"},
        {"\nEXX,EYX\n", "/a.csv: line 2: 'EXX,EYX' names no axis: a header comes first, such as X,EXX,EYX"},
        {"0,1\n", "/a.csv: line 1: '0,1' names no axis: a header comes first, such as X,EXX,EYX"},
        {std::string("\xff\xfeX\0,\0", 6),
         "/a.csv: line 1: '\?\?X?,?' names no axis: a header comes first, such as X,EXX,EYX"},
        {std::string(41, 'e'), "/a.csv: line 1: '" + std::string(40, 'e') +
                                   "...' names no axis: a header comes first, such as X,EXX,EYX"},
        {"X,EXX,\n", "/a.csv: line 1: column 3 has no name"},
        {"X,EXY\n", "/a.csv: line 1: 'EXY' is no error of X, which are EXX EYX EZX EAX EBX ECX"},
        {"X,exx\n", "/a.csv: line 1: 'exx' is no error of X, which are EXX EYX EZX EAX EBX ECX"},
        {"X,Y\n", "/a.csv: line 1: 'Y' is no error of X, which are EXX EYX EZX EAX EBX ECX"},
        {"X,EXX,EYX,EXX\n", "/a.csv: line 1: 'EXX' is there twice"},
        {"X,EXX,X\n", "/a.csv: line 1: 'X' is there twice"},
        {"# no error\nX\n", "/a.csv: line 2: there is no error beside X"},
        {"X,EXX\n", "/a.csv: line 1: X has 0 rows, and needs 2"},
        {"#\nX,EXX\n0,0\n", "/a.csv: line 2: X has 1 row, and needs 2"},
        {"X,EXX\n0,0\nY,EYY\n0,0\n9,0\n", "/a.csv: line 1: X has 1 row, and needs 2"},
        {"X,EXX\n0,0\n9,0\nX,EYX\n", "/a.csv: line 4: X has a table already, in /a.csv, line 1"},
    };
    for (const auto& [text, sentence] : cases) EXPECT_EQ(refusal(text), sentence) << text;
}

TEST(ErrorTableFile, AnErrorMayHaveAColumnForEachDirection) {
    const auto tables =
        tables_of({{"a.csv", closed("X,EXX-,EYX,EXX+\n0,5e-3,1e-3,-5e-3\n50,4e-3,2e-3,-2e-3\n")}});
    const DirectedErrorTable& table = tables.at('X');
    EXPECT_TRUE(table.directed());
    EXPECT_TRUE(table.scale_measured());
    EXPECT_DOUBLE_EQ(table.at(50, 1).at.errors[0], -2e-3);
    EXPECT_DOUBLE_EQ(table.at(50, -1).at.errors[0], 4e-3);
    EXPECT_DOUBLE_EQ(table.at(50, 0).at.errors[0], 1e-3);
    EXPECT_DOUBLE_EQ(table.at(50, -1).at.errors[1], 2e-3);
    EXPECT_DOUBLE_EQ(table.at(50, 1).halves[0], -3e-3);
    EXPECT_DOUBLE_EQ(table.at(25, 1).at.slopes[0], 3e-3 / 50);
    EXPECT_FALSE(tables_of({{"a.csv", closed("X,EYX\n0,1\n2000,1\n")}}).at('X').directed());
}

TEST(ErrorTableFile, RefusesColumnsOfDirectionWithTheirReason) {
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"X,EXX+\n0,0\n9,0\n", "line 1: 'EXX+' stands without 'EXX-'"},
        {"X,EXX-,EYX+\n0,0,0\n9,0,0\n", "line 1: 'EXX-' stands without 'EXX+'"},
        {"X,EXX,EXX+,EXX-\n0,0,0,0\n9,0,0,0\n", "line 1: 'EXX+' stands beside 'EXX'"},
        {"X,EXX+,EXX-,EXX+\n0,0,0,0\n9,0,0,0\n", "line 1: 'EXX+' is there twice"},
        {"X+,EXX+,EXX-\n0,0,0\n9,0,0\n",
         "line 1: 'X+,EXX+,EXX-' names no axis: a header comes first, such as X,EXX,EYX"},
        {"X,EXX+,EXX-\n0,0.11,-0.1\n900,0,0\n",
         "line 2: column EXX+: 0.11 and -0.1 in EXX- differ by more than 0.2 mm"},
        {"X,EXX+,EXX-\n0,0,0\n9,0.05,0.05\n",
         "line 3: column EXX+: from 0 to 0.05 within 9 mm is too steep; is it in mm?"},
        {"X,EXX+,EXX-\n0,0,0\n9,0.03,0.06\n",
         "line 3: column EXX-: from 0 to 0.06 within 9 mm is too steep; is it in mm?"},
        {"X,EXX+,EXX-\n0,0,0\n0.5,0,0.09\n",
         "line 3: column EXX-: from 0 to 0.09 within 0.5 mm is too steep; is it in mm?"},
        {"X,EBX+,EBX-\n0,0,0\n1,0,2e-4\n",
         "line 3: column EBX-: from 0 to 0.0002 within 1 mm is too steep; is it in rad?"},
    };
    for (const auto& [text, sentence] : cases) EXPECT_EQ(refusal(text), "/a.csv: " + sentence) << text;
}

TEST(ErrorTableFile, RefusesARowWithItsReason) {
    const std::vector<std::pair<std::string, std::string>> cases = {
        {"5", "1 value, but the header has 3"},
        {"5,0,001,0", "4 values, but the header has 3"},
        {"5,,0", "column EXX: there is no value"},
        {",0,0", "column X: there is no value"},
        {"5,1.2.3,0", "column EXX: '1.2.3' is no number"},
        {"5,0,1 mm", "column EAX: '1 mm' is no number"},
        {"5,0x1,0", "column EXX: '0x1' is no number"},
        {"5,+-1,0", "column EXX: '+-1' is no number"},
        {"5,+,0", "column EXX: '+' is no number"},
        {"nan,0,0", "column X: 'nan' is no number"},
        {"5,nan,0", "column EXX: 'nan' is no number"},
        {"5,0,-inf", "column EAX: '-inf' is no number"},
        {"5,1e999,0", "column EXX: '1e999' is no number"},
        {"EXX,EXX,EAX", "column X: 'EXX' is no number"},
        {"100001,0,0", "column X: '100001' is beyond 100000 mm; is it in mm?"},
        {"5,-10.5,0", "column EXX: '-10.5' is beyond 10 mm; is it in mm?"},
        {"5,0,0.11", "column EAX: '0.11' is beyond 0.1 rad; is it in rad?"},
        {"0,0,0", "column X: 0 is not beyond 0 by at least 0.001 mm"},
        {"-5,0,0", "column X: -5 is not beyond 0 by at least 0.001 mm"},
        {"0.0009,0,0", "column X: 0.0009 is not beyond 0 by at least 0.001 mm"},
        {"5,0.021,0", "column EXX: from 0 to 0.021 within 5 mm is too steep; is it in mm?"},
        {"5,0,-6e-4", "column EAX: from 0 to -0.0006 within 5 mm is too steep; is it in rad?"},
    };
    for (const auto& [row, words] : cases)
        EXPECT_EQ(refusal("X,EXX,EAX\n0,0,0\n" + row + "\n9,0,0\n"), "/a.csv: line 3: " + words);
    EXPECT_EQ(refusal("X,EXX\n0,0\n40,0.041\n"),
              "/a.csv: line 3: column EXX: from 0 to 0.041 within 40 mm is too steep; is it in mm?");
    EXPECT_EQ(refusal(closed("X,EXX,EAX\n0,0,0\n5,0.02,-5e-4\n10,0,0\n")), "accepted");
}

// The play is taken up where the axis turns, at both ends of a stage of 8 mm.
TEST(ErrorTableFile, ReversalIsNoSlope) {
    const std::string stage =
        "X,EXX+,EXX-\n0,0.017,0.017\n0.5,-0.018,0.018\n4,-0.014,0.021\n7.5,-0.017,0.018\n"
        "8,-0.016,-0.016\n";
    EXPECT_EQ(refusal(closed(stage)), "accepted");
    const DirectedErrorTable table = tables_of({{"a.csv", closed(stage)}}).at('X');
    double steepest = 0;
    for (double x = 0; x <= 8; x += 0.01)
        for (const double d : {-1.0, 1.0})
            steepest = std::max(steepest, std::abs(table.at(x, d).at.slopes[0]));
    EXPECT_GT(steepest, 0.05);
    EXPECT_LT(steepest, 0.5) << "the largest slope that squareness follows";
}

// The file of a copy that broke off, or of a program that is still writing.
void none_but_the_whole_is_taken(std::string whole) {
    ASSERT_EQ(refusal(whole), "accepted") << whole;
    while (whole.back() == '\n' || whole.back() == '\r')
        whole.pop_back();  // of the last line nothing is missing then
    ASSERT_EQ(refusal(whole), "accepted") << whole;
    for (std::size_t length = 0; length < whole.size(); ++length)
        EXPECT_NE(refusal(whole.substr(0, length)), "accepted")
            << "of " << whole.size() << " bytes " << length;
}

std::string with_line_ends(const std::string& text, const std::string& end) {
    std::string result;
    for (const char c : text) result += c == '\n' ? end : std::string(1, c);
    return result;
}

TEST(ErrorTableFile, TakesNoPartOfAFile) {
    const auto table = [](int count) {
        std::string rows = "# machine: mill\n# date: 2026-11-20\n# end mill 10\n\nY,EXY,EYY,EAY\n";
        for (int y = 0; y < count; ++y)
            rows += std::to_string(10 * y) + ",0.00" + std::to_string(y % 10) + ",-1e-3,2.5e-6\n";
        return rows;
    };
    none_but_the_whole_is_taken(closed(table(89)));
    for (const char* end : {"\n", "\r\n", "\n\n", "\r\n\r\n"})
        none_but_the_whole_is_taken(with_line_ends(closed(table(19) + "X,EXX\n0,0\n10,0.001\n"), end));
}

TEST(ErrorTableFile, NamesTheLineThatClosesTheTable) {
    const std::string x = "X,EXX\n0,0\n10,0.001\n", z = "Z,EZZ\n0,0.002\n20,0\n30,0\n",
                      end = "# end, 2 rows\n";
    const std::string not_all =
        " does not count the 2 rows before it: a part may be missing; if they are all, write: ";
    const std::string more =
        "rows or another end follow the end: delete this line, and let the last line be: ";
    for (const auto& [text, sentence] :
         Texts{{x,
                "/a.csv: the end is missing, and with it perhaps a part of the table; if the 2 rows are all, "
                "add as the last line: # end, 2 rows"},
               {x + "# end\n",
                "/a.csv: the end is missing, and with it perhaps a part of the table; if the 2 rows are "
                "all, add as the last line: # end, 2 rows"},
               {x + "# end, 3 rows\n", "/a.csv: line 4: '# end, 3 rows'" + not_all + "# end, 2 rows"},
               {x + "# end, 2\n", "/a.csv: line 4: '# end, 2'" + not_all + "# end, 2 rows"},
               {x + "\n# end, 02 rows", "/a.csv: line 5: '# end, 02 rows'" + not_all + "# end, 2 rows"},
               {x + end + z, "/a.csv: line 4: " + more + "# end, 5 rows"},
               {x + end + z + "# end, 3 rows\n", "/a.csv: line 4: " + more + "# end, 5 rows"},
               {x + end + z + "# end, 5 rows\n", "/a.csv: line 4: " + more + "# end, 5 rows"},
               {x + end + "20,0\n" + end, "/a.csv: line 4: " + more + "# end, 3 rows"},
               {x + end + end, "/a.csv: line 4: " + more + "# end, 2 rows"}})
        EXPECT_EQ(refusal(text), sentence) << text;
    for (const std::string& text :
         {x + end, x + z + "# end, 5 rows", x + end + "\n# by Jo\n", x + "#end, 2 rows,,"})
        EXPECT_EQ(refusal(text), "accepted") << text;
}

std::vector<error_table_file::Facts> facts_of(const Texts& texts) {
    error_table_file::Reader reader;
    for (const auto& [name, text] : texts) reader.read(name, text);
    return reader.files();
}

TEST(ErrorTableFile, ShowsWhatTheHeadStates) {
    const std::string rows = "X,EXX\n0,0\n10,0.001\n";  // whose CRC-32 is that of Python's zlib
    const auto facts = facts_of({{"/a.csv",
                                  "# Machine : portal mill 7 ,,\r\n#date:2026-11-20\n# temperature: 20.1 °C\n"
                                  "# checksum: 540AFF5D\n# note: cold\n" +
                                      closed(rows)},
                                 {"/b.csv", closed("Z,EZZ\n0,0\n9,0\nY,EYY\n0,0\n9,0\n")}});
    ASSERT_EQ(facts.size(), 2u);
    EXPECT_EQ(facts[0].sentence(),
              "/a.csv: error tables of X, 2 rows, machine portal mill 7, date 2026-11-20, "
              "temperature 20.1 °C, no seal");
    EXPECT_EQ(facts[1].sentence(),
              "/b.csv: error tables of Z, Y, 4 rows, no machine, no date, no temperature, no seal");
    EXPECT_EQ(facts[1].advice(),
              "/b.csv has no seal, so a damaged digit can go unseen: check the table, then: "
              "plumb squareness --table /b.csv --seal");
    const std::string head = "# date: 2026-11-20\n" + rows;
    EXPECT_EQ(facts_of({{"c", head + "# end, seal c2da2411, 2 rows\n"}})[0].sentence(),
              "c: error tables of X, 2 rows, no machine, date 2026-11-20, no temperature, seal c2da2411");
}

TEST(ErrorTableFile, RefusesAHeadThatIsWrong) {
    const std::string rows = "X,EXX\n0,0\n10,0.001\n# end, 2 rows\n";
    const std::string changed =
        " is not that of the rows, which were changed or are damaged; check them, then: "
        "plumb squareness --table /a.csv --seal";
    for (const auto& [text, sentence] :
         Texts{{"# checksum: 540aff5e\n" + rows, "/a.csv: line 1: checksum '540aff5e'" + changed},
               {"#\n# checksum: 540aff\n" + rows, "/a.csv: line 2: checksum '540aff'" + changed},
               {"# checksum:\n" + rows, "/a.csv: line 1: there is no checksum"},
               {"# machine: a\n# MACHINE: b\n" + rows, "/a.csv: line 2: the machine is there twice"},
               {rows + "# checksum: 540aff5d\n",
                "/a.csv: line 5: the checksum stands in the head, before the first table"}})
        EXPECT_EQ(refusal(text), sentence) << text;
}

// Lines that end otherwise, or remarks, are no other table.
TEST(ErrorTableFile, AChecksumIsOfTheRowsAlone) {
    const std::string sum = "# checksum: 540aff5d\n", rows = "X,EXX\n0,0\n10,0.001\n";
    for (const std::string& text : {closed(rows), with_line_ends(closed(rows), "\r\n"),
                                    "\n# cold\n" + closed(" X,EXX \n\n0,0\n10,0.001")})
        EXPECT_EQ(refusal(sum + text), "accepted") << text;
    EXPECT_NE(refusal(sum + closed("X,EXX\n0,0\n10,0.002\n")), "accepted");
}

std::string sealed(const std::string& text) {
    return error_table_file::Reader::sealed("/a.csv", text);
}

const std::string laser =
    "# machine: mill 7\n# date: 2026-11-20\n# temperature: 20.1 degC\n# u: EYY 0.3e-3\n\n"
    "Y,EXY,EYY,EAY\n0,0,0,0\n50,0.0012,-0.003,1.5e-5\n# by laser\nX,EXX\n-10,0.001\n0,0\n10,-0.001\n"
    "# end, 5 rows\n";

TEST(ErrorTableFile, NoFlippedBitOfASealedFileIsTaken) {
    for (const std::string& text :
         {laser, with_line_ends(laser, "\r\n"), "\xef\xbb\xbf" + laser,
          std::string("\tX, EXX\n 0 ,0\n10 , 0\n# end, 2 rows"), laser + "# cold\n"}) {
        const std::string whole = sealed(text);
        ASSERT_EQ(refusal(whole), "accepted") << whole;
        ASSERT_NE(facts_of({{"a", whole}})[0].seal, "");
        none_but_the_whole_is_taken(whole);
        for (std::size_t bit = 0; bit < 8 * whole.size(); ++bit) {
            std::string flipped = whole;
            flipped[bit / 8] = static_cast<char>(flipped[bit / 8] ^ 1 << bit % 8);
            EXPECT_NE(refusal(flipped), "accepted")
                << "bit " << bit % 8 << " of byte " << bit / 8 << " of " << whole;
        }
    }
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
    return text.replace(text.find(from), from.size(), to);
}

TEST(ErrorTableFile, AnEditorMayChangeLineEndsAndEmptyLinesOfASealedFile) {
    const std::string whole = sealed(laser);
    const std::string without_end = whole.substr(0, whole.size() - 1);
    for (const std::string& text :
         {with_line_ends(whole, "\r\n"), with_line_ends(whole, "\n\n"), "\xef\xbb\xbf" + whole, "\n" + whole,
          whole + "\n\n", without_end, replaced(whole, "\n\n", "\n")})
        EXPECT_EQ(refusal(text), "accepted") << text;
}

TEST(ErrorTableFile, AnyOtherChangeOfASealedFileIsRefusedWithTheCommandThatSealsIt) {
    const std::string whole = sealed(laser);
    for (const auto& [from, to] : Texts{{"0.0012", "0.0013"},
                                        {"20.1", "23.1"},
                                        {"11-20", "11-21"},
                                        {"mill 7", "mill 8"},
                                        {"0.3e-3", "0.1e-3"},
                                        {"by laser", "by level"},
                                        {"# by laser\n", ""},
                                        {"# date: 2026-11-20\n", ""},
                                        {"0,0,0,0\n", "0,0,0,0 \n"},
                                        {"0,0,0,0\n", "0, 0,0,0\n"},
                                        {"1.5e-5", "15e-6"},
                                        {"# end", "# cold\n# end"}}) {
        const std::string reason = refusal(replaced(whole, from, to));
        EXPECT_NE(reason.find(" is not that of the file, which gives "), std::string::npos) << reason;
        EXPECT_NE(reason.find("check it, then: plumb squareness --table /a.csv --seal"), std::string::npos)
            << reason;
    }
    const std::string more = replaced(whole, "10,-0.001\n", "10,-0.001\n20,0\n");
    const std::string seal = facts_of({{"a", whole}})[0].seal;
    EXPECT_EQ(refusal(more),
              "/a.csv: line 15: '# end, seal " + seal +
                  ", 5 rows' does not count the 6 rows before it: a part may be missing; if they "
                  "are all, write: # end, 6 rows, then: plumb squareness --table /a.csv --seal");
    EXPECT_EQ(refusal({{"/a b's.csv", replaced(whole, "20.1", "2.1")}}).substr(0, 28),
              "/a b's.csv: line 14: seal '" + seal.substr(0, 1));
    EXPECT_NE(refusal({{"/a b's.csv", replaced(whole, "20.1", "2.1")}})
                  .find("plumb squareness --table '/a b'\\''s.csv' --seal"),
              std::string::npos);
}

TEST(ErrorTableFile, ASealChangesNoTableAndReplacesAFormerOne) {
    const std::string rows = "X,EXX\n0,0\n10,0.001\n";  // whose CRC-32 is that of Python's zlib
    EXPECT_EQ(sealed(rows + "# end, 2 rows\n"), rows + "# end, seal 540aff5d, 2 rows\n");
    EXPECT_EQ(sealed("\n" + rows + "# end, 2 rows\n\n\n"), "\n" + rows + "# end, seal 540aff5d, 2 rows\n");
    EXPECT_EQ(sealed(rows + "# end, seal 00000000, 2 rows\n"), rows + "# end, seal 540aff5d, 2 rows\n");
    EXPECT_EQ(sealed("\xef\xbb\xbf# checksum: 00000000\r\nX,EXX \r\n0,0\t\r\n10,0.001\r\n#end, 2 rows,,"),
              "\xef\xbb\xbf" + with_line_ends(rows, "\r\n") + "# end, seal 540aff5d, 2 rows\r\n");
    const std::string once = sealed(laser);
    EXPECT_EQ(sealed(once), once);
    const auto before = tables_of({{"a", laser}}), after = tables_of({{"a", once}});
    for (const double position : {-10.0, 3.0, 50.0})
        for (const char axis : {'X', 'Y'})
            EXPECT_EQ(before.at(axis).at(position).errors, after.at(axis).at(position).errors);
    for (const std::string& text : {rows, rows + "# end, 3 rows\n", rows + "# end, seal 540aff5d, 3 rows\n",
                                    replaced(once, "0.0012", "12")})
        EXPECT_THROW(sealed(text), std::runtime_error) << text;
}

TEST(ErrorTableFile, ASealIsWrittenIntoTheFileThatKeepsItsRights) {
    const Folder folder;
    const std::string file = folder.write("a.csv", laser), link = folder / "link.csv";
    ASSERT_EQ(chmod(file.c_str(), 0640), 0);
    ASSERT_EQ(symlink(file.c_str(), link.c_str()), 0);
    seal_error_table(link);
    EXPECT_EQ(contents(file), sealed(laser));
    struct stat state {};
    ASSERT_EQ(lstat(file.c_str(), &state), 0);
    EXPECT_EQ(state.st_mode & 07777, 0640u);
    EXPECT_TRUE(std::filesystem::is_symlink(link));
    EXPECT_NE(read_error_tables({file}).files[0].seal, "");

    const std::string wrong = laser.substr(0, laser.size() / 2);
    folder.write("b.csv", wrong);
    EXPECT_THROW(seal_error_table(folder / "b.csv"), std::runtime_error);
    EXPECT_EQ(contents(folder / "b.csv"), wrong);
    EXPECT_THROW(seal_error_table(folder / "none.csv"), std::runtime_error);
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        names.push_back(entry.path().filename());
    EXPECT_THAT(names, testing::UnorderedElementsAre("a.csv", "b.csv", "link.csv"));
}

TEST(ErrorTableFile, RefusesASecondTableOfAnAxisInAnotherFile) {
    const std::string x = closed("X,EXX\n0,0\n10,0.001\n");
    EXPECT_EQ(refusal({{"/a.csv", x}, {"/b.csv", "#\n" + x}}),
              "/b.csv: line 2: X has a table already, in /a.csv, line 1");
}

TEST(ErrorTableFile, TakesAsManyRowsAsItStatesAndNotOneMore) {
    std::string text = "X,EXX\n";
    for (int i = 0; i < 4096; ++i) text += std::to_string(i) + ",0\n";
    EXPECT_EQ(refusal(closed(text)), "accepted");
    EXPECT_EQ(refusal(text + "4096,0\n"), "/a.csv: line 4098: more than 4096 rows");
}

TEST(ErrorTableFile, ReadsFilesAndRefusesWhatIsNone) {
    const Folder folder;
    const std::string x = folder.write("x.csv", closed("X,EXX\n0,0\n10,0.001\n"));
    const std::string y = folder.write("y.csv", closed("Y,EYY\n0,0.002\n10,0\n"));
    EXPECT_EQ(read_error_tables({x, y}).tables.at('Y').at(0).errors[1], 0.002);
    EXPECT_TRUE(read_error_tables({}).tables.empty());

    const std::string missing = folder / "none.csv", here = folder / ".";
    const std::string large = folder.write("large.csv", std::string((4 << 20) + 1, '#'));
    for (const auto& [file, words] : {std::pair(missing, "No such file or directory"),
                                      {here, "is no regular file"},
                                      {std::string("/dev/zero"), "is no regular file"},
                                      {large, "is longer than 4 MiB"}}) {
        try {
            read_error_tables({file});
            ADD_FAILURE() << "not refused: " << file;
        } catch (const std::runtime_error& error) {
            EXPECT_EQ(error.what(), file + ": " + words);
        }
    }
}

}  // namespace
}  // namespace plumb
