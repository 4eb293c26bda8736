// Where LinuxCNC's own interpreter goes, the reader goes too. Skipped where /usr/bin/rs274 is not installed.

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "trunnion/base/quantity.hpp"

#include "reading.hpp"

namespace trunnion::nc {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr const char* interpreter = "/usr/bin/rs274";
constexpr double printed_mm = 2e-3;  ///< it prints four digits, in inches where the program is

struct Stop {
    bool feed = false;
    Vector3d place_mm = Vector3d::Zero();
};

/// The numbers between the brackets of a canonical call.
std::vector<double> numbers_of(const std::string& line) {
    std::vector<double> numbers;
    for (std::size_t at = line.find('('); at != line.npos; at = line.find(',', at + 1))
        numbers.push_back(std::strtod(line.c_str() + at + 1, nullptr));
    return numbers;
}

void go(std::vector<Stop>& stops, bool feed, const Vector3d& place_mm) {
    if (stops.empty() || (stops.back().place_mm - place_mm).norm() > printed_mm) stops.push_back({feed, place_mm});
}

/// Where the straight moves of the interpreter end, with the shifts that it prints apart. It starts in inches.
/// It keeps its tool table in the home folder and empties it at its start, under the feet of any other that runs: each
/// has the program's folder for its home.
std::vector<Stop> by_linuxcnc(const fs::path& program) {
    const std::string command =
        fmt::format("HOME={} {} -g {} 2>/dev/null", program.parent_path().string(), interpreter, program.string());
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::vector<Stop> stops;
    Vector3d offset_mm = Vector3d::Zero(), shift_mm = Vector3d::Zero();
    double unit_mm = inch_mm;
    std::array<char, 400> line{};
    while (pipe && std::fgets(line.data(), static_cast<int>(line.size()), pipe.get())) {
        const std::string call = line.data();
        const auto vector = [&](std::size_t first) {
            const std::vector<double> numbers = numbers_of(call);
            return numbers.size() < first + 3
                       ? Vector3d(Vector3d::Zero())
                       : Vector3d(unit_mm * Vector3d(numbers[first], numbers[first + 1], numbers[first + 2]));
        };
        if (call.contains("USE_LENGTH_UNITS")) unit_mm = call.contains("MM") ? 1 : inch_mm;
        if (call.contains("SET_G5X_OFFSET")) offset_mm = vector(1);
        if (call.contains("SET_G92_OFFSET")) shift_mm = vector(0);
        if (call.contains("STRAIGHT_FEED") || call.contains("STRAIGHT_TRAVERSE"))
            go(stops, call.contains("FEED"), vector(0) + offset_mm + shift_mm);
    }
    return stops;
}

std::vector<Stop> by_the_reader(const program::Program& program) {
    std::vector<Stop> stops;
    for (std::size_t i = 0; i < program.moves.size(); ++i)
        go(stops, program.moves[i].kind == program::MoveKind::feed && i > 0, program.moves[i].position_mm);
    return stops;
}

struct Comparison {
    const char* name;
    std::string_view text;
};

constexpr Comparison comparisons[] = {
    {"expressions",
     "#1=5 #2=7\nX[#1+2*#2] Y[#1/2]\n#3=9 X#3\nX#3\nXSIN[30] YCOS[60] ZATAN[1]/[2]\nX[7 MOD -3] Y[-7 MOD 3] "
     "Z[-2**2]\nX[ROUND[-2.5]] Y[FIX[-2.5]] Z[FUP[-2.5]]\nX[2**3**2] Y[1 EQ 1.00002] Z[1+2 EQ 3 AND 0]\nX-ABS[-3] Y-#1 "
     "ZLN[EXP[2]]\nX[1 EQ 1.0002] Y[[2 GT 1] XOR [1 GT 2]] ZSQRT[2]\n"},
    {"names", "#<my part>=3 #<_every>=4\nX#<MyPart>\nY#<_every>\nX[#<_x>+1]\nZ[#5422-1]\nX[EXISTS[#<none>]+5]\n"},
    {"branches",
     "o1 while [#1 LT 6]\n#1=[#1+1]\no2 if [#1 EQ 2]\no1 continue\no2 elseif [#1 EQ 5]\no1 break\no2 else\nX#1\no2 "
     "endif\no1 endwhile\nX9\n"},
    {"loops",
     "o1 do\n#1=[#1+1]\nX#1\no1 while [#1 LT 3]\no2 repeat [3]\nY[#5421+1]\no3 repeat [2]\nZ[#5422-1]\no3 "
     "endrepeat\no2 endrepeat\n"},
    {"subprograms",
     "o100 sub\nX[#1+10] Y#2\no101 if [#1 GT 4]\no100 return [#1]\no101 endif\n#1=77\no100 endsub [#1*2]\n#1=3\no100 "
     "call [3] [4]\nX#<_value>\no100 call [5]\nX#<_value> Y#1\n"},
    {"recursion", "o1 sub\no2 if [#1 GT 0]\nX#1\no1 call [#1-1]\nY#1\no2 endif\no1 endsub\no1 call [5]\n"},
    {"m98", "#1=5\nM98 P100 L2\nX#1\nM2\nO100\nG91 X#1\nG90 Y#1\n#1=[#1+2]\nM99\n"},
    {"g92", "G92 X0 Y0\nG1 X3 Y4\nG92.2\nX1\nG92.3\nX2\nG52 X4 Z1\nX1 Z2\nG92.1\nX7 Y1\n"},
    {"g10", "G10 L20 P1 X0 Y0\nG1 X3\nG92 Y5\nG10 L20 P1 X7\nX8 Y6\nG91 X1\n"},
    {"drilling",
     "G98 G81 X3 Y4 Z1 R5\nX6\nG99 Y6\nG82 X2 Y2 Z1 R5 P1\nX1 P2\nG80\nG0 Z20\nG98 G85 X4 Z1 R4\nG89 X5 Z2 R4 P1\nG86 "
     "X6 Z2 R4 P1\n"},
    {"pecking", "G99 G83 X3 Y4 Z1 R5 Q1.5\nX5 Q3\nG73 X7 Z1 R5 Q2\nG98 X8\n"},
    {"incremental_cycles", "G98 G91 G81 X1 Y1 Z-1 R-2 L3\nG99 G81 X1 Z-1 R-2 L2\nG90 G0 X20\n"},
    {"tapping", "G98 G84 X3 Y4 Z1 R5\nM4\nG74 X5 Z1 R5\n"},
    {"planes", "G18 G98 G81 X2 Z1 R5 Y-1\nG19 G99 G81 X-5 R1 Y3 Z3\nG17 G99 G81 Z-9 R-2 X2\n"},
    {"inches", "G20 X1 Y.5\n#1=#5420\nG21\nX#1 Y#5421\n"},
    {"state", "M70 G91\nX1\nM72\nX1\no1 sub\nM73\nG91 X5\no1 endsub\no1 call\nX2\n"},
};

class AgainstLinuxcnc : public testing::TestWithParam<Comparison> {};

TEST_P(AgainstLinuxcnc, GoesTheSameWay) {
    if (!fs::exists(interpreter)) GTEST_SKIP() << interpreter << " is absent";
    const fs::path folder =
        fs::temp_directory_path() / fmt::format("trunnion_against_linuxcnc_{}_{}", GetParam().name, getpid());
    fs::create_directories(folder);
    const fs::path file = folder / "program.ngc";
    std::ofstream(file) << "G21 G90 G94 G17 F600 S100 M3\nG0 X1 Y2 Z10\n" << GetParam().text << "M2\n";
    const auto program = read_program_file(file, {});
    ASSERT_TRUE(program) << said(program);
    const std::vector<Stop> theirs = by_linuxcnc(file), ours = by_the_reader(*program);
    fs::remove_all(folder);
    ASSERT_GT(theirs.size(), 2u);
    ASSERT_EQ(ours.size(), theirs.size());
    for (std::size_t i = 0; i < ours.size(); ++i) {
        EXPECT_LT((ours[i].place_mm - theirs[i].place_mm).norm(), printed_mm)
            << "move " << i << ": " << ours[i].place_mm.transpose() << " for " << theirs[i].place_mm.transpose();
        EXPECT_EQ(ours[i].feed, theirs[i].feed) << "move " << i;
    }
}

INSTANTIATE_TEST_SUITE_P(Rs274, AgainstLinuxcnc, testing::ValuesIn(comparisons),
                         [](const auto& test) { return std::string(test.param.name); });

}  // namespace
}  // namespace trunnion::nc
