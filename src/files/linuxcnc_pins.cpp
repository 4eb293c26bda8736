#include "detail/linuxcnc_pins.hpp"

#include <optional>
#include <set>

#include <fmt/format.h>

#include "trunnion/base/number.hpp"

namespace trunnion::files::detail {

namespace {

/// The HAL commands that give a pin its value: `setp`, or `net` and `sets`.
class HalReading {
  public:
    HalReading(const LinuxcncIni& ini, std::string_view module, const HalFileReader& hal_file)
        : ini_(ini), prefix_(fmt::format("{}.", module)), hal_file_(hal_file) {}

    Result<void> file(const IniEntry& named);
    Result<void> command(const IniEntry& where, std::string_view line);
    Result<std::map<std::string, double, std::less<>>> pins() const;

  private:
    Result<void> lines(const IniEntry& named, std::string_view text);
    std::optional<std::string> with_ini_values(std::string_view line) const;
    void connect(const std::vector<std::string_view>& words);
    bool is_ours(std::string_view pin) const { return pin.starts_with(prefix_); }

    const LinuxcncIni& ini_;
    std::string prefix_;
    const HalFileReader& hal_file_;
    std::map<std::string, std::string, std::less<>> set_pins_, signal_of_pin_, set_signals_;
    const IniEntry* last_ = nullptr;
};

/// `[SECTION]KEY` and `[SECTION](KEY)` in a HAL line are values of the INI.
std::optional<std::string> HalReading::with_ini_values(std::string_view line) const {
    std::string out;
    while (true) {
        const auto open = line.find('['), close = line.find(']', std::min(open, line.size()));
        if (open == line.npos || close == line.npos) return out.append(line);
        out += line.substr(0, open);
        const std::string_view section = line.substr(open + 1, close - open - 1);
        line.remove_prefix(close + 1);
        const bool bracket = line.starts_with('(');
        if (bracket) line.remove_prefix(1);
        const auto end = std::min(line.find_first_of(bracket ? ")" : " \t"), line.size());
        const IniEntry* entry = ini_.find(section, line.substr(0, end));
        if (!entry) return {};
        out += entry->value;
        line.remove_prefix(std::min(end + (bracket ? 1 : 0), line.size()));
    }
}

void HalReading::connect(const std::vector<std::string_view>& words) {
    for (std::size_t i = 2; i < words.size(); ++i)
        if (is_ours(words[i])) signal_of_pin_[std::string(words[i])] = words[1];
}

Result<void> HalReading::command(const IniEntry& where, std::string_view written) {
    last_ = &where;
    if (written.find(prefix_) == written.npos && !written.starts_with("sets")) return {};
    const auto line = with_ini_values(written.substr(0, written.find('#')));
    if (!line) return fail(ini_.at(where, "FILE0125", fmt::format("a key of '{}' is not in the INI", written)));
    const auto words = words_of(*line);
    if (words.size() == 3 && words[0] == "setp" && is_ours(words[1])) set_pins_[std::string(words[1])] = words[2];
    if (words.size() == 3 && words[0] == "sets") set_signals_[std::string(words[1])] = words[2];
    if (words.size() >= 3 && words[0] == "net") connect(words);
    if (words.size() == 3 && words[0] == "linksp" && is_ours(words[2]))
        signal_of_pin_[std::string(words[2])] = words[1];
    return {};
}

Result<void> HalReading::lines(const IniEntry& named, std::string_view text) {
    while (!text.empty()) {
        const auto end = std::min(text.find('\n'), text.size());
        auto line = text.substr(0, end);
        line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
        if (line.starts_with("source "))
            return fail(ini_.at(named, "FILE0125", "the HAL file has another one carried out",
                                "name that file in [HAL] instead"));
        if (auto good = command(named, line); !good) return good;
        text.remove_prefix(std::min(end + 1, text.size()));
    }
    return {};
}

/// Files of LinuxCNC's own library know nothing of this machine's lengths.
Result<void> HalReading::file(const IniEntry& named) {
    const auto words = words_of(named.value);
    if (words.empty() || words[0].starts_with("LIB:")) return {};
    const std::string name(words[0]);
    if (name.ends_with(".tcl"))
        return fail(ini_.at(named, "FILE0125", "a program sets the pins; it is not carried out here",
                            "set the lengths of the kinematics in a .hal file or by HALCMD = setp …"));
    const auto text = hal_file_(name);
    if (!text) return fail(ini_.at(named, "FILE0125", "a HAL file cannot be read", "it is looked for beside the INI"));
    return lines(named, *text);
}

Result<std::map<std::string, double, std::less<>>> HalReading::pins() const {
    auto texts = set_pins_;
    for (const auto& [pin, signal] : signal_of_pin_) {
        const auto set = set_signals_.find(signal);
        if (set != set_signals_.end())
            texts[pin] = set->second;
        else if (!pin.ends_with(".tool-offset"))  // comes from the tool table while it runs
            texts[pin] = fmt::format("of the signal {}", signal);
    }
    std::map<std::string, double, std::less<>> out;
    for (const auto& [pin, text] : texts) {
        std::string_view rest = text;
        auto value = take_number(rest, Exponent::allowed);
        if (text == "TRUE" || text == "true") value = 1, rest = {};
        if (text == "FALSE" || text == "false") value = 0, rest = {};
        if (!value || !rest.empty())
            return fail(ini_.at(*last_, "FILE0125", fmt::format("the value of {} cannot be told: {}", pin, text),
                                "give it by setp or sets"));
        out[pin.substr(prefix_.size())] = *value;
    }
    return out;
}

}  // namespace

Result<std::map<std::string, double, std::less<>>> pins_of_module(const LinuxcncIni& ini, std::string_view module,
                                                                  const HalFileReader& hal_file) {
    HalReading reading(ini, module, hal_file);
    for (const char* key : {"HALFILE", "HALCMD", "POSTGUI_HALFILE"})
        for (const IniEntry* entry : ini.all("HAL", key)) {
            const bool is_file = std::string_view(key) != "HALCMD";
            auto good = is_file ? reading.file(*entry) : reading.command(*entry, entry->value);
            if (!good) return fail(good.error());
        }
    return reading.pins();
}

}  // namespace trunnion::files::detail
