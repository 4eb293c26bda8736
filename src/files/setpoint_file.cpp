#include "trunnion/files/setpoint_file.hpp"

#include <iterator>

#include <fmt/format.h>

#include "trunnion/base/quantity.hpp"

namespace trunnion::files {

namespace {

constexpr std::size_t flush_at = 1 << 18;
constexpr std::size_t npy_header_size = 128;

/// Header of a NumPy array file, version 1.0, padded to a fixed size so that it can be written anew with the row count.
std::string npy_header(std::size_t rows, std::size_t columns) {
    std::string text = fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}, {}), }}", rows, columns);
    const std::size_t length = npy_header_size - 10;
    text.resize(length - 1, ' ');
    text += '\n';
    std::string out = "\x93NUMPY";
    out += '\x01';
    out += '\0';
    out += static_cast<char>(length & 0xff);
    out += static_cast<char>(length >> 8);
    return out + text;
}

void append_double(std::string& out, double value) {
    out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::vector<std::string> setpoint_columns(const machine::Machine& machine) {
    std::vector<std::string> out{"t_s"};
    for (int i = 0; i < machine.axis_count; ++i)
        out.push_back(fmt::format("{}_{}", machine.axes[i].letter, machine.axes[i].rotary ? "deg" : "mm"));
    out.insert(out.end(), {"line", "s_mm", "feed_mm_min"});
    return out;
}

SetpointFile::SetpointFile(OutputFile file, const machine::Machine& machine, bool binary)
    : file_(std::move(file)), machine_(&machine), binary_(binary) {
    const auto columns = setpoint_columns(machine);
    buffer_ = binary ? npy_header(0, columns.size()) : fmt::format("{}\n", fmt::join(columns, ","));
}

Result<SetpointFile> SetpointFile::create(const std::filesystem::path& path, const machine::Machine& machine) {
    auto file = OutputFile::create(path);
    if (!file) return fail(file.error());
    return SetpointFile(std::move(*file), machine, path.extension() == ".npy");
}

void SetpointFile::write(const motion::Setpoint& row) {
    ++rows_;
    if (binary_) {
        append_double(buffer_, row.time_s);
        for (int i = 0; i < machine_->axis_count; ++i)
            append_double(buffer_, machine_->axes[i].rotary ? row.position[i] / degree : row.position[i]);
        append_double(buffer_, row.line);
        append_double(buffer_, row.path_length_mm);
        append_double(buffer_, row.feed_mm_s * 60);
    } else {
        auto out = std::back_inserter(buffer_);
        fmt::format_to(out, "{}", row.time_s);
        for (int i = 0; i < machine_->axis_count; ++i)
            fmt::format_to(out, ",{}", machine_->axes[i].rotary ? row.position[i] / degree : row.position[i]);
        fmt::format_to(out, ",{},{:.6f},{:.4f}\n", row.line, row.path_length_mm, row.feed_mm_s * 60);
    }
    if (buffer_.size() > flush_at) flush();
}

void SetpointFile::flush() {
    file_.write(buffer_);
    buffer_.clear();
}

Result<void> SetpointFile::commit() {
    flush();
    if (binary_) file_.rewrite_start(npy_header(rows_, setpoint_columns(*machine_).size()));
    return file_.commit();
}

}  // namespace trunnion::files
