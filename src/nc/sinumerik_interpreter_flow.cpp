#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "detail/sinumerik_interpreter_machinery.hpp"

namespace trunnion::nc::sinumerik {

namespace {

using Direction = FlowIndex::Direction;

bool is_jump(std::string_view word) {
    return word == "GOTOF" || word == "GOTOB" || word == "GOTO" || word == "GOTOC" || word == "GOTOS";
}

Direction direction_of(std::string_view word) {
    if (word == "GOTOF") return Direction::forward;
    if (word == "GOTOB") return Direction::backward;
    return Direction::forward_first;
}

}  // namespace

Interpreter::Machinery::Statement Interpreter::Machinery::statement_named(std::string_view name) {
    using M = Machinery;
    static constexpr std::pair<std::string_view, Statement> statements[] = {
        {"DEF", &M::define},
        {"IF", &M::if_statement},
        {"ELSE", &M::else_statement},
        {"ENDIF", &M::nothing_to_do},
        {"FOR", &M::for_statement},
        {"ENDFOR", &M::back_to_begin},
        {"WHILE", &M::while_statement},
        {"ENDWHILE", &M::back_to_begin},
        {"LOOP", &M::nothing_to_do},
        {"ENDLOOP", &M::back_to_begin},
        {"REPEAT", &M::repeat_statement},
        {"UNTIL", &M::until_statement},
        {"REPEATB", &M::repeat_block},
        {"CASE", &M::case_statement},
        {"GOTO", &M::jump_word},
        {"GOTOF", &M::jump_word},
        {"GOTOB", &M::jump_word},
        {"GOTOC", &M::jump_word},
        {"GOTOS", &M::jump_word},
        {"PROC", &M::procedure},
        {"EXTERN", &M::external},
        {"CALL", &M::call_statement},
        {"EXTCALL", &M::call_statement},
        {"PCALL", &M::refused_call},
        {"RET", &M::return_statement},
        {"ENDPROC", &M::return_statement},
        {"MCALL", &M::modal_call},
    };
    const auto* const found = std::ranges::find(statements, name, [](const auto& entry) { return entry.first; });
    return found == std::end(statements) ? nullptr : found->second;
}

/// Statements that stand alone in their line.
bool Interpreter::Machinery::lone_word(Block& block, int column) {
    return (first_ && block.words.empty()) ||
           refuse("NC0524", column, "must stand first in its line",
                  cursor_.line().substr(static_cast<std::size_t>(column - 1), 12), "put it in a line of its own");
}

bool Interpreter::Machinery::flow(FlowIndex*& index, std::string_view block_number) {
    const Program& program = frame().program;
    std::unique_ptr<FlowIndex>& made = program.section->flow;
    if (!made || (!block_number.empty() && !made->block_numbers().contains(block_number))) {
        FlowIndex::BlockNumbers wanted = made ? made->block_numbers() : FlowIndex::BlockNumbers{};
        if (!block_number.empty()) wanted.emplace(block_number);
        Cursor scan = cursor_;
        made = std::make_unique<FlowIndex>(std::move(wanted));
        if (!made->build(*program.source, *program.section, scan)) return false;
    }
    index = made.get();
    return true;
}

bool Interpreter::Machinery::structure(int column, const Structure*& found) {
    FlowIndex* index = nullptr;
    if (!flow(index)) return false;
    found = first_ ? index->structure_at(here_.at.offset) : nullptr;
    return found || refuse("NC0524", column, "a control structure needs a line of its own", {},
                           "a jump is IF condition GOTOF label");
}

/// The control goes on at `next`. Repeated parts that are left that way are over.
void Interpreter::Machinery::go_to(const LinePlace& next) {
    Frame& running = frame();
    running.next = next;
    auto& repetitions = running.repetitions;
    while (!repetitions.empty() &&
           (next.offset < repetitions.back().start.offset || next.offset > repetitions.back().end))
        repetitions.pop_back();
    line_done_ = true;
}

bool Interpreter::Machinery::end_line(const LinePlace& next) {
    if (!cursor_.want_end()) return false;
    go_to(next);
    return true;
}

bool Interpreter::Machinery::find_target(std::string_view name, Direction direction, int column, const Target*& found) {
    const bool block_number = name.size() > 1 && name[0] == 'N' && is_digit(name[1]);
    FlowIndex* index = nullptr;
    if (!flow(index, block_number ? name : std::string_view{})) return false;
    found = index->find(name, direction, here_.at.offset);
    if (!found || !index->enters_structure(*found, here_.at.offset)) return true;
    return refuse("NC0523", column, "jumps into a control structure", name,
                  fmt::format("line {} lies within one", found->line.at.line));
}

bool Interpreter::Machinery::jump(std::string_view name, Direction direction, bool if_there, int column) {
    const Target* target = nullptr;
    if (!find_target(name, direction, column, target)) return false;
    if (target) {
        go_to(target->line.at);
        return true;
    }
    return if_there || refuse("NC0521", column, "no such label or block number in that direction", name,
                              "labels count within their own program");
}

/// The name of a label, a block number, or a text that says one.
bool Interpreter::Machinery::target_name(std::string& name) {
    const int column = cursor_.next_column();
    const char c = cursor_.front();
    const std::string_view word = cursor_.peek_name();
    const Variable* const variable = variables_.find(word);
    if (c == '"' || c == '(' || (variable && variable->type == Type::text)) {
        Value text;
        if (!expressions_.value(text)) return false;
        name = in_capitals(written(text));
        return true;
    }
    name = cursor_.name();
    return !name.empty() || refuse("NC0524", column, "the target of the jump is missing");
}

/// GOTOF label. Where the jump is not carried out the statement is read all the same.
bool Interpreter::Machinery::jump_statement(bool carried_out) {
    const int column = cursor_.next_column();
    const std::string_view word = cursor_.name();
    if (!is_jump(word)) return refuse("NC0524", column, "GOTOF, GOTOB, GOTO, GOTOC or GOTOS is missing", word);
    if (word == "GOTOS") {
        if (carried_out) go_to(frame().program.section->begin);
        return true;
    }
    std::string name;
    if (!target_name(name)) return false;
    return !carried_out || jump(name, direction_of(word), word == "GOTOC", column);
}

bool Interpreter::Machinery::jump_word(Block&, int column) {
    cursor_.go_back_to(column);
    return jump_statement(true) && (line_done_ || cursor_.want_end());
}

bool Interpreter::Machinery::if_statement(Block&, int column) {
    bool holds = false;
    if (!expressions_.condition(holds)) return false;
    if (!is_jump(cursor_.peek_name())) {
        const Structure* choice = nullptr;
        if (!structure(column, choice) || !cursor_.want_end()) return false;
        if (!holds) go_to(choice->has_middle ? choice->middle.behind : choice->end.behind);
        return true;
    }
    if (!jump_statement(holds)) return false;
    return line_done_ || cursor_.peek_name() == "IF" || cursor_.want_end();
}

/// What ran before it was the part for a true condition.
bool Interpreter::Machinery::else_statement(Block&, int column) {
    const Structure* choice = nullptr;
    return structure(column, choice) && end_line(choice->end.behind);
}

/// LOOP and ENDIF.
bool Interpreter::Machinery::nothing_to_do(Block&, int column) {
    const Structure* whole = nullptr;
    return structure(column, whole) && cursor_.want_end();
}

/// ENDFOR, ENDWHILE and ENDLOOP.
bool Interpreter::Machinery::back_to_begin(Block&, int column) {
    const Structure* loop = nullptr;
    if (!structure(column, loop) || !end_line(loop->begin.at)) return false;
    frame().counting = loop->kind == Structure::Kind::count ? frame().program.section->flow->number_of(*loop) : -1;
    return true;
}

/// FOR variable = first TO last. The end must stay what it was: what the control does when it moves is not documented.
bool Interpreter::Machinery::for_statement(Block&, int column) {
    const Structure* loop = nullptr;
    if (!structure(column, loop)) return false;
    Frame& running = frame();
    const int number = running.program.section->flow->number_of(*loop);
    const bool again = std::exchange(running.counting, -1) == number;
    const int at = cursor_.next_column();
    const std::string_view name = cursor_.name();
    Reference counter;
    if (!expressions_.is_variable(name)) return refuse("NC0502", at, "FOR counts with a variable", name);
    if (!expressions_.reference(name, at, counter) || !cursor_.want("=")) return false;
    Value first;
    if (again) {
        first = variables_.read(counter);
        if (first.kind == Value::Kind::number) first.number += 1;
        cursor_.goes_to_word("TO");
    } else {
        if (!expressions_.number(first.number)) return false;
        if (!cursor_.take_word("TO")) return refuse("NC0524", cursor_.next_column(), "TO is missing");
    }
    double last = 0;
    if (!variables_.assign(counter, first, cursor_, at) || !expressions_.number(last) || !cursor_.want_end())
        return false;
    if (!again) running.count_ends[number] = last;
    if (last != running.count_ends[number])
        return refuse("NC0525", at, "the end of FOR changes while it counts", fmt::format("{}", last),
                      fmt::format("it was {}: use WHILE", running.count_ends[number]));
    if (variables_.read(counter).number > last) go_to(loop->end.behind);
    return true;
}

bool Interpreter::Machinery::while_statement(Block&, int column) {
    const Structure* loop = nullptr;
    bool holds = false;
    if (!structure(column, loop) || !expressions_.condition(holds) || !cursor_.want_end()) return false;
    if (!holds) go_to(loop->end.behind);
    return true;
}

bool Interpreter::Machinery::until_statement(Block&, int column) {
    const Structure* loop = nullptr;
    bool holds = false;
    if (!structure(column, loop) || !expressions_.condition(holds) || !cursor_.want_end()) return false;
    if (!holds) go_to(loop->begin.behind);
    return true;
}

/// CASE expression OF constant GOTOF label … DEFAULT GOTOF label
bool Interpreter::Machinery::case_statement(Block&, int) {
    Value wanted;
    if (!expressions_.value(wanted)) return false;
    if (!cursor_.take_word("OF")) return refuse("NC0524", cursor_.next_column(), "OF is missing");
    while (!line_done_ && !cursor_.at_end()) {
        bool fits = cursor_.take_word("DEFAULT");
        if (!fits && !expressions_.equals(wanted, fits)) return false;
        if (!jump_statement(fits)) return false;
    }
    return true;
}

/// P=n or Pn.
bool Interpreter::Machinery::times(double& count) {
    const std::string_view word = cursor_.peek_name();
    if (!word.starts_with('P') || (word.size() > 1 && !is_digit(word[1]))) return true;
    cursor_.take("P");
    cursor_.take("=");
    return expressions_.whole(0, most_repetitions, "repetitions", count);
}

/// REPEAT alone starts a loop; REPEAT label [label] [P=n] carries out that part again.
bool Interpreter::Machinery::repeat_statement(Block& block, int column) {
    if (cursor_.at_end()) return nothing_to_do(block, column);
    if (!lone_word(block, column)) return false;
    std::string first, last;
    if (!target_name(first)) return false;
    const std::string_view next = cursor_.peek_name();
    const bool two = is_own_name(next);
    if (two && !target_name(last)) return false;
    const Target *start = nullptr, *end = nullptr;
    if (!find_target(first, Direction::backward_first, column, start)) return false;
    if (!start) return refuse("NC0521", column, "no such label", first);
    const std::size_t begin = start->line.at.offset;
    FlowIndex* index = nullptr;
    if (!flow(index)) return false;
    end = index->find(two ? last : "ENDLABEL", Direction::forward, begin);
    if (two && !end && last != first) return refuse("NC0521", column, "no such label behind the first one", last);
    if (two && last == first) end = start;
    // An end behind the REPEAT that follows the start does not count: then the part goes up to the REPEAT.
    const bool up_to_here = begin < here_.at.offset && (!end || end->line.at.offset > here_.at.offset);
    if (begin == here_.at.offset || (!up_to_here && !end))
        return refuse("NC0526", column, "the part to be repeated has no end", first,
                      "it ends at a second label, at ENDLABEL, or at the REPEAT behind it");
    return repeat(start->line.at, up_to_here ? here_.at.offset : end->line.behind.offset, column);
}

/// REPEATB label [P=n]: that one line.
bool Interpreter::Machinery::repeat_block(Block& block, int column) {
    if (!lone_word(block, column)) return false;
    std::string name;
    const Target* target = nullptr;
    if (!target_name(name) || !find_target(name, Direction::backward_first, column, target)) return false;
    if (!target) return refuse("NC0521", column, "no such label", name);
    if (target->line.at.offset == here_.at.offset)
        return refuse("NC0526", column, "a line does not repeat itself", name);
    return repeat(target->line.at, target->line.behind.offset, column);
}

bool Interpreter::Machinery::repeat(const LinePlace& start, std::size_t end, int column) {
    double count = 1;
    if (!times(count) || !cursor_.want_end()) return false;
    if (count == 0) return true;
    Frame& running = frame();
    if (running.repetitions.size() >= static_cast<std::size_t>(limits_.calls))
        return refuse("NC0541", column, "too many repeated parts within each other", {},
                      fmt::format("at most {}", limits_.calls));
    running.repetitions.push_back({.start = start, .resume = here_.behind, .end = end, .left = count});
    running.next = start;
    line_done_ = true;
    return true;
}

/// At the end of a repeated part: back to its start, or on behind the REPEAT.
bool Interpreter::Machinery::turn_back(Frame& running) {
    if (running.repetitions.empty() || running.next.offset != running.repetitions.back().end) return false;
    Repetition& repetition = running.repetitions.back();
    if (--repetition.left > 0) {
        running.next = repetition.start;
    } else {
        running.next = repetition.resume;
        running.repetitions.pop_back();
    }
    return true;
}

}  // namespace trunnion::nc::sinumerik
