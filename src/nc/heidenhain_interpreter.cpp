#include "detail/heidenhain_interpreter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace trunnion::nc::heidenhain {

namespace {

constexpr std::size_t most_calls = 16;
constexpr double most_repetitions = 65534;

/// Numbers as the control compares them.
bool same(double a, double b) {
    return std::abs(a - b) <= 1e-9 * std::max({1.0, std::abs(a), std::abs(b)});
}

}  // namespace

Interpreter::Interpreter(const ProgramText& text, std::string_view file_name, Findings& findings,
                         std::int64_t most_repeated_lines)
    : findings_(findings),
      main_("", text),
      folder_(file_name),
      values_(cursor_, findings),
      blocks_left_(most_repeated_lines) {
    frames_.push_back({.source = &main_});
}

bool Interpreter::in_main_program() const {
    return std::ranges::count(frames_, true, &Frame::program) == 1;
}

Interpreter::Outcome Interpreter::refuse(std::string_view code, std::size_t at, std::string text,
                                         std::string_view value, std::string_view hint) {
    findings_.refuse(code, cursor_.spot(at), std::move(text), value, hint);
    return Outcome::refused;
}

Interpreter::Step Interpreter::next() {
    for (;;) {
        Outcome outcome = Outcome::done;
        switch (frames_.back().source->next(frames_.back().place, statement_)) {
            case Source::Taken::statement:
                cursor_.start(statement_);
                outcome = carry_out();
                break;
            case Source::Taken::end:
                outcome = end_of_text();
                break;
            case Source::Taken::too_long:
                findings_.refuse("NC0748", statement_.spot(0), "a block of more than 20 000 characters");
                return Step::refused;
        }
        if (outcome == Outcome::block) return Step::block;
        if (outcome == Outcome::ended) return Step::end;
        if (outcome == Outcome::refused) return Step::refused;
    }
}

/// The text once is free.
bool Interpreter::count_block() {
    const std::size_t behind = frames_.back().place.offset;
    if (frames_.size() > 1 || behind <= furthest_) return --blocks_left_ >= 0;
    furthest_ = behind;
    return true;
}

Interpreter::Outcome Interpreter::carry_out() {
    if (!count_block())
        return refuse("NC0743", 0, "the program does not end: too many blocks were carried out again", {},
                      "a jump or a repeat without an end?");
    switch (cursor_.front()) {
        case 'B':
            return cursor_.take_word("BEGIN") ? begin_program() : Outcome::block;
        case 'E':
            return cursor_.take_word("END") ? end_program() : Outcome::block;
        case 'L':
            return cursor_.behind_front() == 'B' && cursor_.take_word("LBL") ? label() : Outcome::block;
        case 'C':
            return cursor_.behind_front() == 'A' && cursor_.take_word("CALL") ? call() : Outcome::block;
        case 'Q':
            return values_.assignment() ? done() : Outcome::refused;
        case 'I':
            return cursor_.take_word("IF") ? condition() : Outcome::block;
        case 'F':
            return cursor_.behind_front() == 'N' && cursor_.take_word("FN") ? function() : Outcome::block;
        default:
            return Outcome::block;
    }
}

/// Nothing more stands in the block.
Interpreter::Outcome Interpreter::done() {
    if (cursor_.at_end()) return Outcome::done;
    return refuse("NC0737", cursor_.index(), "nothing more can stand in this block", cursor_.rest().substr(0, 12));
}

Interpreter::Outcome Interpreter::begin_program() {
    if (!cursor_.take_word("PGM")) return refuse("NC0204", 0, "unknown word: it might change motion");
    const std::string_view words = trimmed(cursor_.rest());
    const std::size_t last = words.find_last_of(" \t");
    const std::string_view unit = last == words.npos ? words : words.substr(last + 1);
    const bool inch = reads(unit, "INCH") || reads(unit, "IN");
    if (!inch && !reads(unit, "MM"))
        return refuse("NC0749", cursor_.next_index(), "BEGIN PGM without its unit of length", unit, "MM or INCH");
    frames_.back().inch = inch;
    cursor_.go_back_to(0);
    return Outcome::block;
}

Interpreter::Outcome Interpreter::end_program() {
    if (!cursor_.take_word("PGM")) return refuse("NC0204", 0, "unknown word: it might change motion");
    return end_of_text();
}

Interpreter::Outcome Interpreter::end_of_text() {
    if (!frames_.back().program)
        return refuse("NC0744", 0, "the program ends within a subprogram", {}, "LBL 0 ends a subprogram");
    if (frames_.size() > 1) return leave(), Outcome::done;
    Frame& frame = frames_.back();
    if (Statement rest; frame.source->next(frame.place, rest) == Source::Taken::statement)
        findings_.count("NC0014", Severity::warning, rest.spot(0), "END PGM", "text behind the end is left out");
    return Outcome::ended;
}

void Interpreter::leave() {
    if (frames_.back().program) values_.parameters().leave_program();
    frames_.pop_back();
}

bool Interpreter::enter(Frame frame, std::size_t at) {
    if (frames_.size() > most_calls) {
        refuse("NC0742", at, "too many subprograms within each other", {}, "at most 16");
        return false;
    }
    frame.outer_line = line();
    if (frame.program) values_.parameters().enter_program();
    frames_.push_back(std::move(frame));
    return true;
}

// ------------------------------------------------------------------------------------------------- labels and calls

Interpreter::Outcome Interpreter::label() {
    if (label_name(cursor_.rest()) == "0" && !frames_.back().program) leave();
    return Outcome::done;
}

bool Interpreter::find_label(LinePlace& place) {
    const std::size_t at = cursor_.next_index();
    std::string name;
    if (const auto quoted = cursor_.quoted())
        name = '"' + std::string(*quoted);
    else if (is_digit(cursor_.front()))
        name = label_name(cursor_.bare());
    if (name.empty()) {
        refuse("NC0741", at, "a label is a number or a name in quotation marks", cursor_.rest().substr(0, 12));
        return false;
    }
    const Source::Found found = frames_.back().source->label(name, place);
    if (found == Source::Found::once && name != "0") return true;
    refuse("NC0741", at, found == Source::Found::twice ? "a label that stands more than once" : "no such label",
           name.starts_with('"') ? name + '"' : name);
    return false;
}

Interpreter::Outcome Interpreter::call() {
    if (cursor_.take_word("LBL")) return call_label();
    if (cursor_.take_word("PGM")) return call_program();
    return refuse("NC0701", 0, "this call is not supported", cursor_.rest().substr(0, 20), "CALL LBL or CALL PGM");
}

Interpreter::Outcome Interpreter::call_label() {
    const std::size_t at = cursor_.next_index();
    LinePlace place;
    if (!find_label(place)) return Outcome::refused;
    if (cursor_.take_word("REP")) return repeat_from(place);
    if (!cursor_.at_end()) return done();
    Frame frame{.source = frames_.back().source, .place = place, .program = false, .inch = frames_.back().inch};
    const int outer = frames_.back().outer_line;
    if (!enter(std::move(frame), at)) return Outcome::refused;
    frames_.back().outer_line = outer;  // within the text itself a subprogram has lines of its own
    return Outcome::done;
}

/// REP n, or n/m as the control shows it while it runs.
Interpreter::Outcome Interpreter::repeat_from(const LinePlace& label) {
    const std::size_t at = cursor_.next_index();
    double times = 0, shown = 0;
    if (!values_.value(times) || (cursor_.take('/') && !values_.value(shown))) return Outcome::refused;
    if (!(times >= 0 && times <= most_repetitions) || times != std::floor(times))
        return refuse("NC0745", at, "REP is a whole number up to 65534");
    if (!cursor_.at_end()) return done();
    Frame& frame = frames_.back();
    const std::size_t here = frame.place.offset;
    auto repetition = std::ranges::find(frame.repetitions, here, &Repetition::behind);
    if (repetition == frame.repetitions.end()) repetition = frame.repetitions.insert(repetition, {here, times});
    if (repetition->left > 0) {
        --repetition->left;
        frame.place = label;
    } else {
        frame.repetitions.erase(repetition);
    }
    return Outcome::done;
}

Interpreter::Outcome Interpreter::call_program() {
    const std::size_t at = cursor_.next_index();
    const auto quoted = cursor_.quoted();
    const std::string_view name = quoted ? *quoted : cursor_.bare();
    Source* source = nullptr;
    if (!find_program(name, at, source)) return Outcome::refused;
    if (!cursor_.at_end()) return done();
    return enter({.source = source, .inch = frames_.back().inch}, at) ? Outcome::done : Outcome::refused;
}

bool Interpreter::find_program(std::string_view name, std::size_t at, Source*& source) {
    if (const auto known = programs_.find(name); known != programs_.end()) {
        source = known->second.get();
        return true;
    }
    std::unique_ptr<Source> read;
    switch (folder_.read(name, read)) {
        case Folder::Found::file:
            source = read.get();
            programs_.emplace(name, std::move(read));
            return true;
        case Folder::Found::nothing:
            refuse("NC0747", at, "no such program in the folder of the main program", name);
            return false;
        case Folder::Found::outside:
            refuse("NC0746", at, "a program outside the folder of the main program", name,
                   "lay it beside the main program and call it by its name alone");
            return false;
        case Folder::Found::several:
        case Folder::Found::unreadable:
            break;
    }
    refuse("NC0747", at, "the file of this program cannot be read, or there are several", name);
    return false;
}

// ------------------------------------------------------------------------------------------------- FN and conditions

Interpreter::Outcome Interpreter::function() {
    const std::size_t at = cursor_.next_index();
    const auto number = cursor_.number();
    if (!number || !cursor_.take(':'))
        return refuse("NC0738", at, "FN needs its number and a colon", {}, "FN 0: Q1 = +5");
    if (*number <= 8 || *number == 13) return values_.assignment() ? done() : Outcome::refused;
    if (*number <= 12)
        return cursor_.take_word("IF") ? condition() : refuse("NC0738", cursor_.next_index(), "IF is missing");
    if (*number == 14) return refuse("NC0739", at, "the program ends itself with an error here (FN 14)");
    if (*number == 15 || *number == 16) {
        findings_.ignored(cursor_.spot(at), *number == 15 ? "FN 15" : "FN 16");
        return Outcome::done;
    }
    return refuse("NC0738", at, "this FN reads or changes the control itself and is not supported");
}

/// IF a EQU b GOTO LBL n.
Interpreter::Outcome Interpreter::condition() {
    double left = 0, right = 0;
    if (!values_.formula(left)) return Outcome::refused;
    const std::size_t at = cursor_.next_index();
    const std::string relation(cursor_.name());
    if (!values_.formula(right)) return Outcome::refused;
    const bool equal = same(left, right);
    bool holds = false;
    if (relation == "EQU")
        holds = equal;
    else if (relation == "NE")
        holds = !equal;
    else if (relation == "GT")
        holds = !equal && left > right;
    else if (relation == "LT")
        holds = !equal && left < right;
    else
        return refuse("NC0738", at, "IF compares with EQU, NE, GT or LT", relation);
    if (!cursor_.take_word("GOTO") || !cursor_.take_word("LBL"))
        return refuse("NC0738", cursor_.next_index(), "GOTO LBL is missing");
    LinePlace place;
    if (!find_label(place)) return Outcome::refused;
    if (holds) frames_.back().place = place;
    return done();
}

}  // namespace trunnion::nc::heidenhain
