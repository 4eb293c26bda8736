#include "trunnion/files/linuxcnc_machine.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "trunnion/base/number.hpp"
#include "trunnion/base/quantity.hpp"
#include "trunnion/files/machine_file.hpp"

#include "detail/linuxcnc_ini.hpp"
#include "detail/linuxcnc_kinematics.hpp"
#include "detail/linuxcnc_pins.hpp"
#include "detail/toml_reading.hpp"

namespace trunnion::files {

using detail::IniEntry;
using detail::LinuxcncIni;
using detail::LinuxcncKinematics;
using machine::Axis;
using machine::Machine;

namespace {

constexpr double no_limit = 1e99;  ///< what LinuxCNC takes where an INI says nothing

class Import {
  public:
    Import(const LinuxcncIni& ini, const LinuxcncJerk& jerk, const HalFileReader& hal_file)
        : ini_(ini), jerk_(jerk), hal_file_(hal_file) {}
    Result<LinuxcncMachine> operator()(std::string_view file_name);

  private:
    Result<void> find_kinematics();
    Result<void> find_letters(const IniEntry& kinematics, const std::vector<std::string_view>& words);
    Result<void> find_units();
    Result<Axis> axis(char letter) const;
    std::vector<std::string> sections_of(char letter) const;
    Result<void> check_kind(const Axis& axis) const;
    Result<double> smallest(char letter, const char* key) const;
    Result<void> read_range(Axis& axis) const;
    Result<double> jerk(const Axis& axis) const;
    Result<void> read_rapid(Axis& axis) const;
    Result<void> place_rotary_axes();
    void read_words();
    void add_notes();
    Result<void> check_writable() const;
    double unit(bool rotary) const { return rotary ? angle_unit_ : length_unit_; }

    const LinuxcncIni& ini_;
    LinuxcncJerk jerk_;
    const HalFileReader& hal_file_;
    const LinuxcncKinematics* kinematics_ = nullptr;
    std::string joints_;  ///< their letters
    double length_unit_ = 1, angle_unit_ = degree;
    LinuxcncMachine out_;
};

std::string upper(std::string_view text) {
    std::string out;
    for (const char c : text) out += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    return out;
}

Result<void> Import::find_kinematics() {
    const auto entry = ini_.required("KINS", "KINEMATICS");
    if (!entry) return fail(entry.error());
    const auto words = detail::words_of((*entry)->value);
    const auto found =
        std::ranges::find(detail::linuxcnc_kinematics, words.empty() ? "" : words[0], &LinuxcncKinematics::module);
    if (found == detail::linuxcnc_kinematics.end())
        return fail(
            ini_.at(**entry, "FILE0123", "these kinematics are not translated", std::string(detail::linuxcnc_chains)));
    kinematics_ = &*found;
    return find_letters(**entry, words);
}

/// The letters are those of the module's parameter; without it trivkins counts through all letters.
Result<void> Import::find_letters(const IniEntry& kinematics, const std::vector<std::string_view>& words) {
    constexpr std::string_view parameter = "coordinates=";
    joints_ = kinematics_->letters;
    for (const auto word : words)
        if (word.starts_with(parameter)) joints_ = upper(word.substr(parameter.size()));
    const bool counted = kinematics_->module == "trivkins" && kinematics.value.find(parameter) == std::string::npos;
    if (counted) {
        const auto entry = ini_.required("KINS", "JOINTS");
        if (!entry) return fail(entry.error());
        const auto count = ini_.number(**entry);
        if (!count) return fail(count.error());
        joints_ = std::string_view("XYZABCUVW").substr(0, static_cast<std::size_t>(std::clamp(*count, 0.0, 9.0)));
    }
    std::string letters;
    for (const char letter : kinematics_->letters)
        if (joints_.find(letter) != std::string::npos) letters += letter;
    const bool known = joints_.find_first_not_of(kinematics_->letters) == std::string::npos;
    if (known && letters == kinematics_->letters) return {};
    return fail(ini_.at(kinematics, "FILE0123",
                        fmt::format("its joints are those of the axes {}", fmt::join(joints_, " ")),
                        std::string(detail::linuxcnc_chains)));
}

Result<void> Import::find_units() {
    struct Unit {
        std::string_view name;
        double scale;
    };
    constexpr std::array<Unit, 5> lengths{
        {{"mm", 1}, {"metric", 1}, {"in", inch_mm}, {"inch", inch_mm}, {"imperial", inch_mm}}};
    constexpr std::array<Unit, 6> angles{{{"deg", degree},
                                          {"degree", degree},
                                          {"rad", 1},
                                          {"radian", 1},
                                          {"grad", 0.9 * degree},
                                          {"gon", 0.9 * degree}}};
    const auto set = [&](const char* key, const auto& units, double& target) -> Result<void> {
        const auto entry = ini_.required("TRAJ", key);
        if (!entry) return fail(entry.error());
        const auto found = std::ranges::find(units, (*entry)->value, &Unit::name);
        if (found == units.end())
            return fail(ini_.at(**entry, "FILE0122", fmt::format("{} is not a unit that is known", key)));
        target = found->scale;
        return {};
    };
    if (auto good = set("LINEAR_UNITS", lengths, length_unit_); !good) return good;
    return set("ANGULAR_UNITS", angles, angle_unit_);
}

/// Where the limits of an axis are: with its joints, of which a gantry has two, and with itself.
std::vector<std::string> Import::sections_of(char letter) const {
    std::vector<std::string> out;
    for (std::size_t joint = 0; joint < joints_.size(); ++joint)
        if (joints_[joint] == letter) out.push_back(fmt::format("JOINT_{}", joint));
    out.push_back(fmt::format("AXIS_{}", letter));
    return out;
}

Result<double> Import::smallest(char letter, const char* key) const {
    double out = no_limit;
    for (const std::string& section : sections_of(letter)) {
        const auto entry = ini_.required(section, key);
        if (!entry) return fail(entry.error());
        const auto value = ini_.number(**entry);
        if (!value) return value;
        if (!(*value > 0))
            return fail(ini_.at(**entry, "FILE0106", fmt::format("[{}]{} is not above 0", section, key)));
        out = std::min(out, *value);
    }
    return out;
}

Result<void> Import::check_kind(const Axis& axis) const {
    for (const std::string& section : sections_of(axis.letter)) {
        const IniEntry* type = ini_.find(section, "TYPE");
        if (type && (type->value == "ANGULAR") != axis.rotary)
            return fail(ini_.at(*type, "FILE0126", fmt::format("axis {} is of the other type here", axis.letter)));
        const IniEntry* wrapped = ini_.find(section, "WRAPPED_ROTARY");
        if (wrapped && wrapped->value != "0")
            return fail(ini_.at(*wrapped, "FILE0126", "a wrapped axis reads rotary words as places on one turn",
                                "here they are literal; remove the key and write programs so"));
    }
    return {};
}

Result<void> Import::read_range(Axis& axis) const {
    const IniEntry* last = nullptr;
    double low = -no_limit, high = no_limit;
    for (const std::string& section : sections_of(axis.letter))
        for (const bool lower : {true, false}) {
            const IniEntry* entry = ini_.find(section, lower ? "MIN_LIMIT" : "MAX_LIMIT");
            if (!entry) continue;
            const auto value = ini_.number(*entry);
            if (!value) return fail(value.error());
            last = entry;
            if (lower)
                low = std::max(low, *value);
            else
                high = std::min(high, *value);
        }
    const bool has_low = low > -no_limit, has_high = high < no_limit;
    if (has_low != has_high)
        return fail(ini_.at(*last, "FILE0126", fmt::format("axis {} has a limit on one side only", axis.letter),
                            "give both, or none for an endless axis"));
    if (!has_low) return {};
    if (!(low < high))
        return fail(ini_.at(*last, "FILE0108", fmt::format("the range of {} is reversed or empty", axis.letter)));
    axis.range_min = low * unit(axis.rotary);
    axis.range_max = high * unit(axis.rotary);
    return {};
}

Result<double> Import::jerk(const Axis& axis) const {
    const auto& given = axis.rotary ? jerk_.rotary_rad_s3 : jerk_.linear_mm_s3;
    if (given) return *given;
    const IniEntry* entry = ini_.find("TRUNNION", fmt::format("JERK_{}", axis.letter));
    const char* option = axis.rotary ? "--jerk-rotary \"1800 deg/s^3\"" : "--jerk-linear \"50 m/s^3\"";
    if (!entry)
        return fail(ini_.at_file("FILE0124", fmt::format("no jerk limit of axis {}", axis.letter),
                                 fmt::format("LinuxCNC 2.9 has none; give it, for example {}", option)));
    const auto value = ini_.number(*entry);
    if (!value) return value;
    if (!(*value > 0)) return fail(ini_.at(*entry, "FILE0106", "the jerk limit is not above 0"));
    return *value * unit(axis.rotary);
}

/// RAPID_X = velocity acceleration jerk.
Result<void> Import::read_rapid(Axis& axis) const {
    axis.rapid = axis.feed;
    const IniEntry* entry = ini_.find("TRUNNION", fmt::format("RAPID_{}", axis.letter));
    if (!entry) return {};
    std::array<double, 3> values{};
    const auto words = detail::words_of(entry->value);
    bool good = words.size() == values.size();
    for (std::size_t i = 0; good && i < values.size(); ++i) {
        std::string_view rest = words[i];
        const auto value = take_number(rest, Exponent::allowed);
        good = value && rest.empty() && *value > 0;
        values[i] = value.value_or(0) * unit(axis.rotary);
    }
    if (!good)
        return fail(ini_.at(*entry, "FILE0122", "not the velocity, acceleration and jerk of rapids, each above 0"));
    axis.rapid = {values[0], values[1], values[2]};
    return {};
}

Result<Axis> Import::axis(char letter) const {
    Axis out;
    out.letter = letter;
    out.rotary = letter <= 'C';
    out.direction = Eigen::Vector3d::Unit((out.rotary ? letter - 'A' : letter - 'X') % 3);
    if (auto good = check_kind(out); !good) return fail(good.error());
    const auto velocity = smallest(letter, "MAX_VELOCITY"), acceleration = smallest(letter, "MAX_ACCELERATION");
    if (!velocity) return fail(velocity.error());
    if (!acceleration) return fail(acceleration.error());
    const auto jerk = this->jerk(out);
    if (!jerk) return fail(jerk.error());
    out.feed = {*velocity * unit(out.rotary), *acceleration * unit(out.rotary), *jerk};
    if (auto good = read_range(out); !good) return fail(good.error());
    if (auto good = read_rapid(out); !good) return fail(good.error());
    return out;
}

Result<void> Import::place_rotary_axes() {
    const auto pins = detail::pins_of_module(ini_, kinematics_->module, hal_file_);
    if (!pins) return fail(pins.error());
    const auto pin = [&](std::string_view name) {
        const auto found = pins->find(name);
        return found == pins->end() ? 0.0 : found->second;
    };
    const Eigen::Vector3d centre(pin("x-rot-point"), pin("y-rot-point"), pin("z-rot-point"));
    Eigen::Vector3d tilt = centre;
    tilt[kinematics_->side] += pin(kinematics_->side_pin);
    tilt.z() += pin("z-offset");
    const bool reversed = pin("conventional-directions") == 0;
    for (Axis& axis : out_.machine.axes) {
        if (!axis.rotary) continue;
        axis.reversed = reversed;
        axis.point_mm = length_unit_ * (axis.letter == 'C' ? centre : tilt);
    }
    return {};
}

void Import::read_words() {
    const auto list = [&](const char* key) {
        std::vector<std::string> out;
        for (const IniEntry* entry : ini_.all("TRUNNION", key)) out.push_back(entry->value);
        return out;
    };
    out_.machine.words = {list("TCP_ON"), list("TCP_OFF"), list("IGNORE"), list("FOLLOWING")};
}

void Import::add_notes() {
    for (const char* key : {"MAX_LINEAR_VELOCITY", "MAX_LINEAR_ACCELERATION"})
        if (const IniEntry* entry = ini_.find("TRAJ", key); entry && ini_.number(*entry))
            out_.notes.push_back(fmt::format(
                "[TRAJ]{} = {} also bounds the tip on LinuxCNC; a machine file has no such limit", key, entry->value));
    for (const IniEntry* entry : ini_.all("RS274NGC", "REMAP")) {
        const auto words = detail::words_of(entry->value);
        const bool plain =
            !words.empty() && std::ranges::all_of(words[0], [](unsigned char c) { return std::isalnum(c); });
        if (plain)
            out_.notes.push_back(fmt::format("LinuxCNC runs {} as a program: say in [words] what it is", words[0]));
    }
}

/// What was read must fit into a machine file: a name in UTF-8, nothing infinite.
Result<void> Import::check_writable() const {
    const auto read = read_machine(machine_text(out_.machine), out_.machine.file);
    if (!read)
        return fail(
            ini_.at_file("FILE0126", fmt::format("it does not fit into a machine file: {}", read.error().text)));
    if (read->name == out_.machine.name) return {};
    return fail(ini_.at_file("FILE0126", "its name is not text in UTF-8"));
}

Result<LinuxcncMachine> Import::operator()(std::string_view file_name) {
    if (auto good = find_kinematics(); !good) return fail(good.error());
    if (auto good = find_units(); !good) return fail(good.error());
    Machine& machine = out_.machine;
    machine.file = file_name;
    machine.name = std::filesystem::path(file_name).stem().string();
    if (const IniEntry* name = ini_.find("EMC", "MACHINE"); name && !name->value.empty()) machine.name = name->value;
    for (const char letter : kinematics_->letters) {
        auto read = axis(letter);
        if (!read) return fail(read.error());
        machine.axes[static_cast<std::size_t>(machine.axis_count++)] = *read;
        machine.rotary_count += read->rotary ? 1 : 0;
    }
    for (std::size_t i = 0; i < kinematics_->chain.size(); ++i)
        machine.chain[i] = static_cast<std::int8_t>(machine.index_of(kinematics_->chain[i]));
    if (machine.rotary_count > 0)
        if (auto good = place_rotary_axes(); !good) return fail(good.error());
    read_words();
    if (auto good = check_writable(); !good) return fail(good.error());
    add_notes();
    return std::move(out_);
}

}  // namespace

Result<LinuxcncMachine> read_linuxcnc_machine(std::string_view ini, std::string_view file_name,
                                              const LinuxcncJerk& jerk, const HalFileReader& hal_file) {
    const auto parsed = LinuxcncIni::parse(ini, file_name);
    if (!parsed) return fail(parsed.error());
    return Import(*parsed, jerk, hal_file)(file_name);
}

Result<LinuxcncMachine> read_linuxcnc_machine_file(const std::filesystem::path& ini, const LinuxcncJerk& jerk) {
    const auto text = detail::read_text(ini);
    if (!text) return fail(text.error());
    return read_linuxcnc_machine(*text, ini.string(), jerk,
                                 [&](const std::string& name) { return detail::read_text(ini.parent_path() / name); });
}

}  // namespace trunnion::files
