#pragma once

#include <array>
#include <string_view>

namespace trunnion::files::detail {

/// A kinematics module of LinuxCNC whose machines can be described by a machine file.
struct LinuxcncKinematics {
    std::string_view module;
    std::string_view letters;   ///< of the joints, unless the INI says otherwise; sorted as machine::Machine::axes
    std::string_view chain;     ///< workpiece → tool
    std::string_view side_pin;  ///< the offset of the tilting axis across it; empty: no rotary axes
    int side = 0;               ///< along which of X, Y, Z
};

inline constexpr std::array<LinuxcncKinematics, 3> linuxcnc_kinematics{
    {{"trivkins", "XYZ", "XYZ", "", 0},
     {"xyzac-trt-kins", "XYZAC", "CAXYZ", "y-offset", 1},
     {"xyzbc-trt-kins", "XYZBC", "CBXYZ", "x-offset", 0}}};

/// For the end of a refusal.
inline constexpr std::string_view linuxcnc_chains =
    "there are X Y Z (trivkins), C A X Y Z (xyzac-trt-kins) and C B X Y Z (xyzbc-trt-kins)";

}  // namespace trunnion::files::detail
