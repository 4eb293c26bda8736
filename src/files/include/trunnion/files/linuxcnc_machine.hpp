#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "trunnion/base/result.hpp"
#include "trunnion/machine/machine.hpp"

namespace trunnion::files {

/// Machines as LinuxCNC 2.9 configures them: an INI file and the HAL files that it names.
///
/// Kinematics that are translated, with the pins of their module (lengths in the INI's unit, here r = `rot-point`,
/// o = `offset`):
///
///     trivkins         X Y Z
///     xyzac-trt-kins   C A X Y Z; point of C = (r_x, r_y, r_z), point of A = (r_x, r_y + o_y, r_z + o_z)
///     xyzbc-trt-kins   C B X Y Z; point of C = (r_x, r_y, r_z), point of B = (r_x + o_x, r_y, r_z + o_z)
///
/// Both modules count the rotary axes against ISO 841 (`reversed`) unless their pin `conventional-directions` is set,
/// which module versions before 2.9.1 do not have. LinuxCNC's world with tool length L is a set-up with
/// origin = (0, 0, −L) and length = L.

// ---- import

/// What LinuxCNC's files do not say.
struct LinuxcncJerk {
    std::optional<double> linear_mm_s3, rotary_rad_s3;
};

struct LinuxcncMachine {
    machine::Machine machine;
    /// What the files say beyond a machine file: one line each, for a person.
    std::vector<std::string> notes;
};

/// Gives the text of a HAL file by the name that the INI has for it.
using HalFileReader = std::function<Result<std::string>(const std::string& name)>;

/// Limits of an axis are the smaller ones of its joints and of its section [AXIS_…]; an axis without limits of
/// position is endless. Jerk is that of the section [TRUNNION] where there is one (see linuxcnc_configuration), else
/// the one that is given.
///
/// Errors, with the line of the INI: FILE0120 no INI file, FILE0121 section or key missing, FILE0122 value that is no
/// number or no unit, FILE0123 kinematics or letters not translated, FILE0124 no jerk given, FILE0125 the value of a
/// pin of the kinematics cannot be told, FILE0126 something that a machine file cannot say, FILE0106 limit not above 0,
/// FILE0108 range reversed or empty.
Result<LinuxcncMachine> read_linuxcnc_machine(std::string_view ini, std::string_view file_name,
                                              const LinuxcncJerk& jerk, const HalFileReader& hal_file);

/// The same from a file, HAL files beside it. Also FILE0101: the INI cannot be read.
Result<LinuxcncMachine> read_linuxcnc_machine_file(const std::filesystem::path& ini, const LinuxcncJerk& jerk);

// ---- export

struct LinuxcncExport {
    double servo_period_s = 0.001;
    std::string display = "dummy";  ///< dummy: no user interface, LinuxCNC waits for the Enter key
    /// Rows can be played (`trunnion play --linuxcnc`): a switch behind each joint's command takes the drive to the pin
    /// of the same number of `streamer.0`, positions in the joint's unit.
    bool play = false;
    int streamer_depth = 1024;  ///< rows
    /// Not empty: LinuxCNC's queue is planned by `trunnion serve` with this machine (a shipped name or a file without
    /// blanks), through the module trunnion_tp.
    std::string served_machine;
};

/// Texts of files that lie in one folder.
struct LinuxcncConfiguration {
    std::string ini, hal, tool_table, parameters;
};

/// The configuration of a simulated LinuxCNC of this machine: what goes out as joint commands comes back as feedback.
/// For a real one the HAL file is where the drives are connected. `stem`: the files are called stem.ini, stem.hal,
/// stem.tbl and stem.var. Lengths in mm, angles in deg. What LinuxCNC does not know is in the section [TRUNNION]:
/// JERK_X (mm/s³ or deg/s³) for every axis, RAPID_X = velocity acceleration jerk where rapids have limits of their own,
/// and the control's words. Where both limits differ, LinuxCNC gets the smaller one.
///
/// Errors: FILE0123 the chain, a direction or a count that none of the modules has, FILE0122 a servo period of less
/// than 1 µs or more than 1 s, or an empty stem or one with blanks.
Result<LinuxcncConfiguration> linuxcnc_configuration(const machine::Machine& machine, std::string_view stem,
                                                     const LinuxcncExport& options = {});

}  // namespace trunnion::files
