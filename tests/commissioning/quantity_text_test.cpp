// SPDX-License-Identifier: GPL-2.0-or-later
#include "components/commissioning/quantity_text.hpp"
#include "tests/support/refusal.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace plumb {
namespace {

TEST(QuantityText, ReadsAnAngleInEachUnit) {
    const struct {
        const char* text;
        double angle;  // rad
    } cases[] = {
        {"8e-5rad", 8e-5},
        {"0.08 mrad", 8e-5},
        {"-80urad", -8e-5},
        {"+80\xc2\xb5rad", 8e-5},
        {"80\xce\xbcrad", 8e-5},
        {"0.01deg", 0.01 * std::acos(-1) / 180},
        {"0.01\xc2\xb0", 0.01 * std::acos(-1) / 180},
        {"2arcmin", 2 * std::acos(-1) / 10800},
        {"16.5arcsec", 16.5 * std::acos(-1) / 648000},
        {"60um/m", std::atan(60e-6)},
        {"0.06mm/m", std::atan(60e-6)},
        {"0.02mm/300mm", std::atan(0.02 / 300)},
        {" -0.02 mm / 300 mm ", -std::atan(0.02 / 300)},
        {"20um/30cm", std::atan(20e-6 / 0.3)},
        {"0.02/300", std::atan(0.02 / 300)},
        {"0.001in/ft", std::atan(0.001 / 12)},
        {"1thou/12in", std::atan(0.001 / 12)},
        {"0", 0},
        {"0arcsec", 0},
    };
    for (const auto& row : cases) EXPECT_NEAR(angle_of(row.text), row.angle, 1e-17) << row.text;
}

TEST(QuantityText, RefusalOfAnAngleNamesTextAndReason) {
    const std::string units =
        "; there are: rad mrad urad deg arcmin arcsec, or a length per length, such as 0.02mm/300mm";
    const std::string lengths = "; there are: um mm cm m in ft thou";
    const std::pair<std::string, std::string> cases[] = {
        {"5", "'5' has no unit" + units},
        {"5 turns", "'5 turns' has an unknown unit, 'turns'" + units},
        {"5mm", "'5mm' has an unknown unit, 'mm'" + units},
        {"", "'' does not begin with a number"},
        {"arcsec", "'arcsec' does not begin with a number"},
        {"0,02mm/300mm", "'0,02mm/300mm' has a comma: a decimal point is a point"},
        {"nanarcsec", "'nanarcsec' is beyond all numbers"},
        {"1e999rad", "'1e999rad' is beyond all numbers"},
        {"0.02mm/300", "'0.02mm/300' has a unit on one side of / only, such as 0.02mm/300mm has on both"},
        {"0.02/300mm", "'0.02/300mm' has a unit on one side of / only, such as 0.02mm/300mm has on both"},
        {"0.02mm/0mm", "'0.02mm/0mm' is not per a length of more than 0"},
        {"0.02mm/-300mm", "'0.02mm/-300mm' is not per a length of more than 0"},
        {"0.02mm/", "'0.02mm/' has nothing behind /"},
        {"/300mm", "'/300mm' does not begin with a number"},
        {"2arcsec/m", "'2arcsec/m' has an unknown unit, 'arcsec'" + lengths},
        {"2mm/m/m", "'2mm/m/m' has an unknown unit, 'm/m'" + lengths},
    };
    for (const auto& [text, reason] : cases) EXPECT_EQ(refusal([&text = text] { angle_of(text); }), reason);
}

TEST(QuantityText, ReadsLengths) {
    EXPECT_DOUBLE_EQ(length_of("0.02mm"), 0.02);
    EXPECT_DOUBLE_EQ(length_of("-5 um"), -0.005);
    EXPECT_DOUBLE_EQ(length_of("12in"), 304.8);
    EXPECT_EQ(length_of("0"), 0);
    EXPECT_EQ(refusal([] { length_of("300"); }), "'300' has no unit; there are: um mm cm m in ft thou");
    EXPECT_EQ(refusal([] { length_of("-1e305m"); }), "'-1e305m' is longer than 1 km");
    EXPECT_EQ(refusal([] { length_of("3rad"); }),
              "'3rad' has an unknown unit, 'rad'; there are: um mm cm m in ft thou");
}

TEST(QuantityText, ListsOfLengthsTakeTheLastUnit) {
    EXPECT_EQ(lengths_of("0:150:300mm"), (std::vector<double>{0, 150, 300}));
    EXPECT_EQ(lengths_of("1mm:2in"), (std::vector<double>{1, 50.8}));
    EXPECT_EQ(lengths_of("3mm"), std::vector<double>{3});
    EXPECT_EQ(lengths_of("0:0"), (std::vector<double>{0, 0}));
    EXPECT_EQ(refusal([] { lengths_of("1:2"); }), "'1' has no unit; there are: um mm cm m in ft thou");
    EXPECT_EQ(refusal([] { lengths_of("1::2mm"); }), "'' does not begin with a number");
    EXPECT_EQ(refusal([] { lengths_of("1mm:"); }), "'' does not begin with a number");
}

}  // namespace
}  // namespace plumb
