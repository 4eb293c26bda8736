#include <cmath>
#include <cstdint>
#include <string>

#include <gtest/gtest.h>

#include "fanuc_reading.hpp"
#include "random.hpp"
#include "sound.hpp"

namespace trunnion::nc {
namespace {

constexpr std::string_view seeds[] = {
    "%\nO1 (a)\nN1 G21 G90 G94 G54\nT8 M6 S3500 M3\nG0 X0 Y0 B0 C0\nG43 H8 Z10.\n#1=3\nWHILE[#1GT0]DO1\nG1 X[#1*2] "
    "Y-#1 "
    "F600\n#1=#1-1\nEND1\nG91 G28 Z0\nG90 G0 Z5.\nG81 R2. Z-3. X4.\nG80\nM98 P9\nIF[#1 EQ 0]GOTO 5\nX9.\nN5 G65 P9 "
    "A1.\nM30\nO9\nG1 X1.\nM99\n%\n",
    "%\nO2\nG20 G0 X0 Y0 Z1. B0 C0\nG43.4 H1 Z1.\nG1 X1. B20. C400. F10.\nG93 X2. F3.\nG94 F9.\nG2 X3. I.5\nG6.2 P3 K0 "
    "X3. "
    "Y0 Z1.\nK0 X4.\nK0 X5. R2.\nK1.\nK1.\nK1.\nG49\nG68.2 X0 Y0 Z0 I0 J30. K0\nG53.1\nG0 X0 Y0\nG43 H1 Z1.\nG83 R.1 "
    "Z-1. "
    "Q.3\nG69\nG53 G0 Z0\nG0 B10.\nG254\nX0 Y0 Z1.\nG255\nM2\n",
    "O3\nG21 G0 X0 Y0 Z0\nG52 X1.\nG51.1 Y0\nG68 X0 Y0 R30.\nG1 X5. F100\nG69\nG50.1\nG92 X0\nG10 L2 P2 X0 Y0 "
    "Z0\nG43.5 H1\nG1 "
    "X1. I0 J.1 K1.\nG4 P10\nM97 P7 L3\nM30\nN7 G91 X1.\nM99\n",
};
constexpr std::string_view pieces[] = {
    "[",     "]",    "#",     "#1=", "(",     ")",     ";",     "%", "\n",  "N5", "GOTO5", "DO1",          "END1",
    "WHILE", "IF",   "THEN",  "M99", "M98P9", "G65P9", "G66P9", "X", "1e9", "-",  ".",     "G28",          "G53",
    "G43.5", "G254", "G68.2", "K",   "R",     "Q0",    "O9",    "/", "*",   "=",  "P1",    "999999999999", "\xff",
    " "};

std::string mutated(std::string text, Random& random) {
    for (std::size_t changes = 1 + random.below(4); changes > 0; --changes) {
        const std::size_t at = random.below(text.size() + 1);
        const std::size_t kind = random.below(5);
        const std::size_t amount = 1 + random.below(9);
        if (kind == 0) text.insert(at, pieces[random.below(std::size(pieces))]);
        if (kind == 1) text.erase(at, amount);
        if (kind == 2) text.resize(at);
        if (kind == 3) text.insert(at, text.substr(random.below(text.size() + 1), amount));
        if (kind == 4 && at < text.size()) text[at] = static_cast<char>(1 + random.below(255));
    }
    return text;
}

TEST(FanucMutations, ReadOrRefusedButSound) {
    constexpr std::uint64_t seed = 20260301;
    SCOPED_TRACE(seed);
    RecordProperty("seed", std::to_string(seed));
    Random random{seed};
    int read = 0, refused = 0;
    for (int i = 0; i < 6000; ++i) {
        const std::string text = mutated(std::string(seeds[random.below(std::size(seeds))]), random);
        ReadOptions options;
        options.feed_given_elsewhere = random.below(2) == 0;
        options.most_repeated_lines = 2000;
        const auto program = read_fanuc_text(text, options);
        SCOPED_TRACE(text);
        if (program)
            expect_sound(*program);
        else
            ASSERT_TRUE(program.error().code.starts_with("NC0") && !program.error().text.empty());
        ++(program ? read : refused);
    }
    EXPECT_GT(read, 300) << "the mutations should leave some programs readable";
    EXPECT_GT(refused, 300);
}

}  // namespace
}  // namespace trunnion::nc
