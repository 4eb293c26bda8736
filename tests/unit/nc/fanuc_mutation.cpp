#include "fanuc_reading.hpp"
#include "mutation.hpp"

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

TEST(FanucMutations, ReadOrRefusedButSound) {
    expect_read_or_refused(
        {20260301, 6000, seeds, pieces},
        [](std::string_view text, const ReadOptions& options, Random&) { return read_fanuc_text(text, options); },
        expect_sound);
}

}  // namespace
}  // namespace trunnion::nc
