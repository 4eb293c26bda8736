#include "detail/read_parts.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "detail/dialects.hpp"
#include "detail/text.hpp"

namespace trunnion::nc {

using program::Move;
using program::Program;

namespace {

constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
constexpr std::size_t bytes_of_a_block = 32;  ///< about
constexpr std::size_t moves_behind = 4096;    ///< of the block that completes a part

OpenReader& reader_of(Dialect dialect) {
    switch (dialect) {
        case Dialect::apt:
            return open_apt;
        case Dialect::rs274:
            return open_rs274;
        case Dialect::sinumerik:
            return open_sinumerik;
        case Dialect::heidenhain:
            return open_heidenhain;
        case Dialect::fanuc:
            break;
    }
    return open_fanuc;
}

Diagnostic binary(std::string_view text, std::size_t nul, std::string_view file) {
    const auto lines = std::ranges::count(text.substr(0, nul), '\n');
    return {.code = "NC0003",
            .text = "a NUL byte: this is no text",
            .place = {.file = std::string(file), .line = number_behind(static_cast<int>(lines))},
            .hint = "give the part program itself"};
}

/// Whether a value may stand behind a letter: a number, a variable, an expression; but A3=0.1 is another address.
bool takes_value(std::string_view behind) {
    behind = skip_blanks(behind);
    if (behind.empty()) return false;
    const char c = upper(behind.front());
    if (!is_digit(c)) return std::string_view("+-.=[#Q").contains(c);
    while (!behind.empty() && is_digit(behind.front())) behind.remove_prefix(1);
    return !skip_blanks(behind).starts_with('=');
}

/// Whether a line may say a word of this letter. Rather yes than no, but what is surely comment does not count.
bool line_says(std::string_view line, char letter, bool comments_in_brackets) {
    line = line.substr(0, line.find(';'));
    if (trimmed(line).starts_with('*')) return false;
    int depth = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (comments_in_brackets) depth += line[i] == '(' ? 1 : line[i] == ')' ? -1 : 0;
        if (depth > 0 || upper(line[i]) != letter) continue;
        const char before = i == 0 ? ' ' : upper(line[i - 1]);
        const bool within_word = (is_letter(before) && before != 'I') || before == '_' || before == '<';
        if (!within_word && takes_value(line.substr(i + 1))) return true;
    }
    return false;
}

bool text_says(const ProgramText& text, char letter, bool comments_in_brackets) {
    LineScanner lines(text.again());
    for (std::string_view line; lines.next(line);)
        if (line_says(line, letter, comments_in_brackets)) return true;
    return false;
}

}  // namespace

Result<std::unique_ptr<ReadParts>> ReadParts::open(ProgramText text, std::optional<TextFile> file,
                                                   std::string_view file_name, const ReadOptions& options) {
    std::size_t behind = 0;
    ProgramText start = text.again();
    start.line(0, behind);
    if (start.nul()) return fail(binary(text.view(), *start.nul(), file_name));
    if (text.view().starts_with(byte_order_mark)) text = text.without(byte_order_mark.size());
    auto dialect = recognise_lines(text);
    if (!dialect && (!options.dialect || dialect.error().code == "NC0002")) {
        dialect.error().place.file = file_name;
        return fail(std::move(dialect.error()));
    }
    std::unique_ptr<ReadParts> parts(new ReadParts(std::move(file), options));
    auto reader = reader_of(options.dialect ? *options.dialect : *dialect)(text, file_name, parts->options_);
    if (!reader) return fail(std::move(reader.error()));
    parts->reader_ = std::move(*reader);
    return parts;
}

Result<bool> ReadParts::next(Program& part) {
    if (error_) return fail(*error_);
    if (ended_) return false;
    const std::size_t likely = reader_->text().size() / bytes_of_a_block + 1;
    reader_->reuse(part, std::min(likely, options_.parts.most) + moves_behind);
    for (;;) {
        if (const auto last = end_of_part()) return part_up_to(*last, part);
        switch (reader_->read_block()) {
            case BlockReader::Step::end:
                return last_part(part);
            case BlockReader::Step::refused:
                return refused(reader_->findings().take_error());
            case BlockReader::Step::block:
                if (!check_block() || !check_letters()) return refused(reader_->findings().take_error());
        }
    }
}

bool ReadParts::check_block() {
    if (reader_->line() < options_.most_lines) return true;
    return reader_->findings().refuse("NC0020", {reader_->line(), 1}, "more lines than can be counted",
                                      fmt::format("{}", reader_->line()), "cut the program in parts");
}

/// A NUL byte ends the text before the line in which it stands: then all that a reader says of this end is not so.
Result<bool> ReadParts::refused(Diagnostic diagnostic) {
    const auto nul = reader_->position() >= reader_->text().size() ? nul_byte() : std::nullopt;
    error_ = nul ? *nul : std::move(diagnostic);
    return fail(*error_);
}

std::optional<Diagnostic> ReadParts::nul_byte() const {
    ProgramText text = reader_->text();
    text.look_to_the_end();
    if (!text.nul()) return {};
    const std::string_view whole{text.view().data(), *text.nul()};
    return binary(whole, *text.nul(), reader_->program().source);
}

// --------------------------------------------------------------------------------------------------------------- parts

Result<bool> ReadParts::part_up_to(std::size_t last, Program& part) {
    leave_open(reader_->program().moves[last]);
    reader_->give_out(last, part);
    looked_at_ = 1;
    return true;
}

Result<bool> ReadParts::last_part(Program& part) {
    if (auto nul = nul_byte()) return refused(std::move(*nul));
    if (!reader_->finish() || !check_letters()) return refused(reader_->findings().take_error());
    reader_->give_out_rest(part);
    ended_ = true;
    return true;
}

/// The last move of the part, once the one behind it has been read.
std::optional<std::size_t> ReadParts::end_of_part() {
    const Program& program = reader_->program();
    if (std::max(program.moves.size(), program.events.size()) <= options_.parts.to_rapid || reader_->waits()) return {};
    for (; looked_at_ + 1 < program.moves.size(); ++looked_at_) {
        if (!can_end(looked_at_)) continue;
        const std::size_t moves = program.moves.size();
        if (!started_) reader_->leave_out_start();
        started_ = true;
        if (program.moves.size() == moves) return looked_at_;
        looked_at_ = 0;
    }
    return {};
}

bool ReadParts::can_end(std::size_t move) {
    const Program& program = reader_->program();
    const std::size_t size = std::max(move, program.events.size());
    const bool at_rapid = size >= options_.parts.to_rapid && program.moves[move + 1].kind == program::MoveKind::rapid;
    const bool stands = size >= options_.parts.to_stop && stands_behind(move);
    const bool must = size >= options_.parts.most;
    if (!(at_rapid || stands || must) || !is_known(program.moves[move])) return false;
    if (std::ranges::binary_search(program.surface_jobs, move + 1, {}, &program::SurfaceJob::before_move)) return false;
    if (at_rapid || stands) return true;
    reader_->findings().count("NC0019", Severity::warning, {program.moves[move].line, 1}, "stop",
                              fmt::format("{} moves without a rapid or a stop: a standstill is made", move),
                              "a rapid, a dwell or an exact stop where the tool may stand still");
    reader_->stop_behind(move);
    return true;
}

bool ReadParts::stands_behind(std::size_t move) const {
    const Program& program = reader_->program();
    if (program.moves[move].exact_stop) return true;
    return std::ranges::any_of(std::ranges::equal_range(program.events, move + 1, {}, &program::Event::before_move),
                               &program::Event::stops_motion);
}

/// Every coordinate, and every rotary axis that the program may ever use.
bool ReadParts::is_known(const Move& move) {
    if (move.position_mm.hasNaN()) return false;
    if (move.law == program::OrientationLaw::vector) return true;
    for (std::size_t axis = 0; axis < move.rotary_rad.size(); ++axis)
        if (std::isnan(move.rotary_rad[axis]) && may_be_said(axis)) return false;
    return true;
}

bool ReadParts::may_be_said(std::size_t axis) {
    const char letter = reader_->rotary_letter(axis);
    if (letter == '\0') return false;
    if (reader_->is_said(axis)) return true;
    if (said_[axis] == Said::not_looked_for) {
        const std::string& dialect = reader_->program().dialect;
        const bool brackets = dialect == name_of(Dialect::rs274) || dialect == name_of(Dialect::fanuc);
        said_[axis] = text_says(reader_->text(), letter, brackets) ? Said::perhaps : Said::never;
    }
    return said_[axis] == Said::perhaps;
}

void ReadParts::leave_open(const Move& move) {
    if (move.law == program::OrientationLaw::vector) return;
    for (std::size_t axis = 0; axis < left_open_.size(); ++axis)
        left_open_[axis] = left_open_[axis] || !reader_->is_said(axis);
}

/// No part has ended where an axis was not known that the program uses after all: a file that it calls says it.
bool ReadParts::check_letters() {
    for (std::size_t axis = 0; axis < left_open_.size(); ++axis) {
        const char letter = reader_->rotary_letter(axis);
        if (left_open_[axis] && reader_->is_said(axis))
            return reader_->findings().refuse(
                "NC0021", {reader_->line(), 1},
                "a file that the program calls is the first to say this axis, behind what "
                "has been read and planned",
                {&letter, 1}, "say the axis at the start of the program");
    }
    return true;
}

}  // namespace trunnion::nc
