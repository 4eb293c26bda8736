#pragma once

#include <map>
#include <string>
#include <string_view>

#include "trunnion/files/linuxcnc_machine.hpp"

#include "linuxcnc_ini.hpp"

namespace trunnion::files::detail {

/// Values that the HAL files of an INI and its HALCMD lines leave in the pins of one module, by the pin's name behind
/// the module's. Pins of which nothing is said are not in it: they are 0. Errors: FILE0125.
Result<std::map<std::string, double, std::less<>>> pins_of_module(const LinuxcncIni& ini, std::string_view module,
                                                                  const HalFileReader& hal_file);

}  // namespace trunnion::files::detail
