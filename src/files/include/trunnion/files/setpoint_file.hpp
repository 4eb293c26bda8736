#pragma once

#include <optional>
#include <string>
#include <vector>

#include "trunnion/files/output_file.hpp"
#include "trunnion/machine/machine.hpp"
#include "trunnion/motion/setpoint.hpp"

namespace trunnion::files {

/// Names of the setpoint columns of a machine: `t_s`, `X_mm` … `A_deg` …, `line`, `s_mm`, `feed_mm_min`.
std::vector<std::string> setpoint_columns(const machine::Machine& machine);

/// Writes setpoints as CSV (`.csv`, `.csv.gz`; numbers read back to the same double) or as one float64 array (`.npy`),
/// row by row, in constant memory. Errors as OutputFile.
class SetpointFile {
  public:
    static Result<SetpointFile> create(const std::filesystem::path& path, const machine::Machine& machine);
    void write(const motion::Setpoint& setpoint);
    Result<void> commit();

  private:
    SetpointFile(OutputFile file, const machine::Machine& machine, bool binary);
    void flush();

    OutputFile file_;
    const machine::Machine* machine_;
    bool binary_;
    std::size_t rows_ = 0;
    std::string buffer_;
};

}  // namespace trunnion::files
