#include "trunnion/report/page.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "trunnion/base/quantity.hpp"
#include "trunnion/files/output_file.hpp"

#include "detail/blob.hpp"
#include "detail/web_page.hpp"

namespace trunnion::report {

using nlohmann::ordered_json;

namespace {

std::string html_text(std::string_view text) {
    std::string out;
    for (const char c : text) switch (c) {
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '&':
                out += "&amp;";
                break;
            default:
                out += c;
        }
    return out;
}

/// JSON that cannot end the element it stands in, whatever its texts hold: ASCII alone, no `<`, `>`, `&`. Bytes that
/// are no UTF-8 become U+FFFD.
std::string json_text(const ordered_json& json) {
    const std::string plain = json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
    std::string out;
    out.reserve(plain.size());
    for (const char c : plain)
        if (c == '<' || c == '>' || c == '&')
            out += fmt::format("\\u{:04x}", static_cast<int>(c));
        else
            out += c;
    return out;
}

ordered_json limits_json(const machine::AxisLimits& limits, double unit) {
    return {{"velocity", limits.velocity / unit},
            {"acceleration", limits.acceleration / unit},
            {"jerk", limits.jerk / unit}};
}

ordered_json vector_json(const Eigen::Vector3d& v) {
    return {v.x(), v.y(), v.z()};
}

/// Infinite: null.
ordered_json finite(double value) {
    return std::isfinite(value) ? ordered_json(value) : ordered_json(nullptr);
}

ordered_json machine_json(const machine::Machine& machine) {
    ordered_json axes = ordered_json::array();
    for (int a = 0; a < machine.axis_count; ++a) {
        const machine::Axis& axis = machine.axes[static_cast<std::size_t>(a)];
        const double unit = axis.rotary ? degree : 1;
        axes.push_back({{"letter", std::string(1, axis.letter)},
                        {"rotary", axis.rotary},
                        {"reversed", axis.reversed},
                        {"direction", vector_json(axis.direction)},
                        {"point_mm", vector_json(axis.point_mm)},
                        {"range", {finite(axis.range_min / unit), finite(axis.range_max / unit)}},
                        {"limits", limits_json(axis.feed, unit)},
                        {"rapid_limits", limits_json(axis.rapid, unit)}});
    }
    ordered_json chain = ordered_json::array();
    for (int k = 0; k < machine.axis_count; ++k)
        chain.push_back(static_cast<int>(machine.chain[static_cast<std::size_t>(k)]));
    return {{"name", machine.name}, {"file", machine.file}, {"axes", axes}, {"chain", chain}};
}

ordered_json setup_json(const machine::Setup& setup) {
    ordered_json rows = ordered_json::array();
    for (int r = 0; r < 3; ++r) rows.push_back(vector_json(setup.workpiece.rotation.row(r)));
    return {{"file", setup.file}, {"origin_mm", vector_json(setup.workpiece.origin_mm)}, {"rotation", rows}};
}

ordered_json failure_json(const Diagnostic& d) {
    return {{"code", d.code},   {"text", d.text},   {"file", d.place.file}, {"line", d.place.line},
            {"value", d.value}, {"limit", d.limit}, {"hint", d.hint}};
}

ordered_json events_json(const std::vector<PlanRecording::TimedEvent>& events) {
    ordered_json out = ordered_json::array();
    for (const auto& event : events)
        out.push_back({{"time_s", event.time_s}, {"line", event.line}, {"word", event.word}});
    return out;
}

ordered_json json_or_null(const std::string& text) {
    return text.empty() ? ordered_json(nullptr) : ordered_json::parse(text);
}

ordered_json content_json(const PageContent& content, detail::Blob& blob) {
    ordered_json out = {{"program", content.program_name}, {"command", content.command}};
    out["machine"] = machine_json(*content.machine);
    out["setup"] = setup_json(*content.setup);
    out["summary"] = json_or_null(content.summary_json);
    out["others"] = ordered_json::array();
    for (const std::string& other : content.other_json) out["others"].push_back(json_or_null(other));
    out["failure"] = content.failure ? failure_json(*content.failure) : ordered_json(nullptr);
    out["events"] = events_json(content.events);
    out["runs"] = ordered_json::array();
    for (const Recording* run : content.runs) out["runs"].push_back(run->describe(blob));
    const std::string& text = content.program_text;
    const auto bytes = blob.add(std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
    out["text"] = {{"at", bytes.offset}, {"n", bytes.count}, {"type", bytes.type}};
    out["bytes"] = blob.size();
    return out;
}

/// In pieces, so that a browser can take them one by one and stays at hand meanwhile.
void write_blob(files::OutputFile& file, const detail::Blob& blob) {
    constexpr std::size_t piece = 3 * 128 * 1024;
    const std::string bytes = blob.deflated();
    for (std::size_t at = 0; at < bytes.size(); at += piece)
        file.write(fmt::format("<script type=\"application/octet-stream\" class=\"columns\">{}</script>\n",
                               detail::base64(std::string_view(bytes).substr(at, piece))));
}

}  // namespace

Result<void> page_is_there() {
    if (detail::web_page().missing.empty()) return {};
    return fail({.code = "REP0001",
                 .text = "this program was built without the page",
                 .value = std::string(detail::web_page().missing),
                 .hint = "run scripts/install_dependencies.sh, which installs Node.js and the page's packages, and "
                         "build again"});
}

Result<void> write_page(const std::filesystem::path& path, const PageContent& content) {
    if (auto there = page_is_there(); !there) return there;
    auto file = files::OutputFile::create(path);
    if (!file) return fail(file.error());
    const detail::WebPage& page = detail::web_page();
    detail::Blob blob;
    const ordered_json json = content_json(content, blob);
    file->write(
        fmt::format("<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
                    "<meta http-equiv=\"Content-Security-Policy\" content=\"{}\">\n<title>{} · Trunnion</title>\n",
                    page.policy, html_text(content.program_name)));
    file->write(fmt::format("<style>{}</style>\n</head>\n<body>\n<noscript>This page needs JavaScript.</noscript>\n",
                            page.style));
    file->write(fmt::format("<script type=\"application/json\" id=\"content\">{}</script>\n", json_text(json)));
    write_blob(*file, blob);
    file->write(fmt::format("<script>{}</script>\n</body>\n</html>\n", page.script));
    return file->commit();
}

}  // namespace trunnion::report
