#include <algorithm>
#include <cmath>
#include <iterator>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "detail/sinumerik_interpreter_machinery.hpp"

namespace trunnion::nc::sinumerik {

namespace {

/// Words behind PROC that change what is shown or where single blocks stop, not what moves.
constexpr std::string_view harmless_attributes[] = {"DISPLOF", "DISPLON",   "SBLOF",  "SBLON",
                                                    "ICYCOF",  "ACTBLOCNO", "PREPRO", "ACTBLOCKNO"};

/// Names of programs with what the control adds to them: _N_NAME_SPF is NAME.
std::string plain_name(std::string_view name) {
    std::string plain = in_capitals(name);
    if (plain.starts_with("_N_")) plain.erase(0, 3);
    if (plain.ends_with("_SPF") || plain.ends_with("_MPF")) plain[plain.size() - 4] = '.';
    return plain;
}

std::string_view without_ending(std::string_view name) {
    if (name.ends_with(".SPF") || name.ends_with(".MPF")) name.remove_suffix(4);
    return name;
}

}  // namespace

/// NAME, NAME(values), L100, each with P=n behind or Pn in front.
bool Interpreter::Machinery::call(std::string_view name, Block& block, int column) {
    Program program;
    if (!find_program(name, column, program)) return false;
    const bool times_in_front = block.words.size() == 1 && block.words[0].name == "P" && block.words[0].has_value;
    if (!times_in_front && (!first_ || !block.words.empty()))
        return refuse("NC0536", column, "a subprogram is called in a line of its own", name);
    double runs = times_in_front ? block.words[0].value : 1;
    if (!(runs >= 0 && runs <= most_repetitions && runs == std::floor(runs)))
        return refuse("NC0510", block.words[0].column, "repetitions: a whole number is wanted",
                      fmt::format("{}", runs));
    block.words.clear();
    std::vector<Passed> passed;
    if (cursor_.take("(") && !pass_arguments(passed)) return false;
    if (!times(runs)) return false;
    if (!cursor_.at_end())
        return refuse("NC0536", cursor_.column(), "nothing can stand behind the call of a subprogram",
                      cursor_.rest().substr(0, 12));
    return enter(program, std::move(passed), runs, column);
}

bool Interpreter::Machinery::pass_arguments(std::vector<Passed>& passed) {
    if (cursor_.take(")")) return true;
    do {
        if (passed.size() == static_cast<std::size_t>(limits_.words))
            return refuse("NC0545", cursor_.column(), "too many values in brackets", {},
                          fmt::format("at most {}", limits_.words));
        Passed& value = passed.emplace_back();
        if (cursor_.sees(",") || cursor_.sees(")")) continue;
        value.given = true;
        const Cursor start = cursor_;
        const int column = cursor_.next_column();
        if (expressions_.is_variable(cursor_.peek_name())) {
            const std::string_view name = cursor_.name();
            Reference variable;
            if (!expressions_.reference(name, column, variable)) return false;
            if (cursor_.sees(",") || cursor_.sees(")")) value.variable = variable;
            cursor_ = start;
        }
        if (!expressions_.value_for(Type::axis, value.value)) return false;
    } while (cursor_.take(","));
    return cursor_.want(")");
}

bool Interpreter::Machinery::find_program(std::string_view name, int column, Program& program) {
    const std::string_view bare = without_ending(name);
    for (Source* const source : {frame().program.source, &main_}) {
        if (Section* const section = source->section(bare)) {
            program = {source, section};
            return true;
        }
    }
    if (const auto known = programs_.find(name); known != programs_.end()) {
        program = known->second;
        return true;
    }
    std::unique_ptr<Source> source;
    switch (folder_.read(name, source)) {
        case Folder::Found::file:
            break;
        case Folder::Found::nothing:
            return refuse("NC0531", column, "neither a word that is known here nor a subprogram that is there", name,
                          fmt::format("a subprogram stands in the same file (%_N_{0}_SPF) or beside the main program "
                                      "({0}.SPF)",
                                      bare));
        case Folder::Found::several:
            return refuse("NC0533", column, "several files have this name but for capitals", name, "leave one of them");
        case Folder::Found::outside:
            return refuse("NC0532", column, "the subprogram's file leads out of the folder of the main program", name,
                          "copy it into the folder");
        case Folder::Found::unreadable:
            return refuse("NC0533", column, "the subprogram's file cannot be read as text", name);
    }
    Section* const section = source->section(bare);
    program = {source.get(), section ? section : &source->main_section()};
    sources_.push_back(std::move(source));
    programs_.emplace(name, program);
    return true;
}

bool Interpreter::Machinery::enter(const Program& program, std::vector<Passed> passed, double runs, int column) {
    if (runs == 0) return true;
    if (frames_.size() > static_cast<std::size_t>(limits_.calls))
        return refuse("NC0541", column, "too many subprograms within each other", {},
                      fmt::format("at most {}", limits_.calls));
    const Frame& caller = frame();
    const bool from_main_text = caller.outer_line == 0;
    const int outer_line = program.source == &main_ ? 0 : from_main_text ? here_.at.line : caller.outer_line;
    Frame& called = frames_.emplace_back();
    called.program = program;
    called.next = program.section->begin;
    called.outer_line = outer_line;
    called.runs = runs;
    called.passed = std::move(passed);
    variables_.enter(called.scope);
    line_done_ = true;
    return true;
}

/// The program that runs ends: its next run, or back to the one that called it.
bool Interpreter::Machinery::leave() {
    leaving_ = false;
    if (frames_.size() == 1) {
        end_main();
        return true;
    }
    if (!charge_line() || !hand_back(frame())) return false;
    release(frame());
    if (--frame().runs > 0) {
        Frame& again = frame();
        again.next = again.program.section->begin;
        again.begun = false;
        again.repetitions.clear();
        again.counting = -1;
        return true;
    }
    frames_.pop_back();
    variables_.enter(frame().scope);
    return true;
}

void Interpreter::Machinery::end_main() {
    ended_ = true;
    const int line = main_.next_line_that_says_something(furthest_, frame().program.section->end);
    if (line > 0)
        findings_.count("NC0014", Severity::note, {line, 1}, "end",
                        "the text behind the end of the program is not read");
}

/// VAR parameters: what became of them goes to the variables of the caller.
bool Interpreter::Machinery::hand_back(Frame& called) {
    Scope& caller = frames_[frames_.size() - 2].scope;
    for (const auto& [parameter, to] : called.handed_back) {
        const Value value = called.scope.find(parameter)->second.elements.front();
        variables_.enter(caller);
        const bool assigned = variables_.assign(to, value, cursor_, 1);
        variables_.enter(called.scope);
        if (!assigned) return false;
    }
    called.handed_back.clear();
    return true;
}

/// PROC NAME(REAL A, INT B=5, VAR REAL C)
bool Interpreter::Machinery::procedure(Block& block, int column) {
    if (!lone_word(block, column)) return false;
    if (!opens_program_) return refuse("NC0535", column, "PROC must be the first line of its program");
    cursor_.name();
    std::size_t count = 0;
    if (cursor_.take("(") && !cursor_.take(")")) {
        do {
            if (!parameter(count++)) return false;
        } while (cursor_.take(","));
        if (!cursor_.want(")")) return false;
    }
    if (count > 0 && frames_.size() == 1)
        return refuse("NC0534", column, "a subprogram that takes values is no main program", {},
                      "give the program that calls it");
    if (frame().passed.size() > count)
        return refuse("NC0534", column, "more values are handed over than the subprogram takes",
                      fmt::format("{}", frame().passed.size()), fmt::format("it takes {}", count));
    return attributes();
}

/// What the caller leaves out is the default, or 0.
bool Interpreter::Machinery::parameter(std::size_t number) {
    const bool by_reference = cursor_.take_word("VAR");
    const int column = cursor_.next_column();
    const auto type = type_named(cursor_.peek_name());
    if (!type) return refuse("NC0511", column, "no type of variable that is known here", cursor_.peek_name());
    cursor_.name();
    std::size_t longest = 0;
    if (!longest_text(*type, longest)) return false;
    const std::string_view name = cursor_.peek_name();
    const auto& passed = frame().passed;
    const Passed* const given = number < passed.size() && passed[number].given ? &passed[number] : nullptr;
    if (!define_one(*type, longest)) return false;
    if (variables_.find(name)->dimensions > 0)
        return refuse("NC0535", column, "arrays are not handed to subprograms", name, "R parameters reach everywhere");
    if (!given && (by_reference || *type == Type::axis))
        return refuse("NC0534", column, "the caller must hand this over", name);
    if (!given) return true;
    if (by_reference && !given->variable)
        return refuse("NC0534", column, "the caller must hand over a variable", name, "VAR gives its value back");
    if (by_reference) frame().handed_back.emplace_back(name, *given->variable);
    return variables_.assign({.name = std::string(name), .element = 0}, given->value, cursor_, column);
}

bool Interpreter::Machinery::attributes() {
    while (!cursor_.at_end()) {
        const int column = cursor_.column();
        const std::string_view word = cursor_.name();
        if (word == "SAVE")
            return refuse("NC0535", column, "SAVE brings back G words and frames at the end of the subprogram", word,
                          "this is not carried out: state them again behind the call");
        if (std::ranges::find(harmless_attributes, word) == std::end(harmless_attributes))
            return word.empty() ? cursor_.refuse_here()
                                : refuse("NC0535", column, "unknown word behind PROC: it might change motion", word);
    }
    return true;
}

/// EXTERN says what a subprogram takes: its PROC says it again.
bool Interpreter::Machinery::external(Block& block, int column) {
    line_done_ = true;
    return lone_word(block, column);
}

/// CALL "NAME" and EXTCALL "NAME": the name may be worked out.
bool Interpreter::Machinery::call_statement(Block& block, int column) {
    if (!lone_word(block, column)) return false;
    if (cursor_.peek_name() == "BLOCK") return refused_call(block, column);
    const int name_column = cursor_.next_column();
    Value name;
    if (!expressions_.value(name)) return false;
    if (name.kind != Value::Kind::text || name.text.empty())
        return refuse("NC0506", name_column, "the name of a subprogram is a text", written(name));
    if (name.text.find_first_of("/\\:") != name.text.npos)
        return refuse("NC0532", name_column, "a path: subprograms lie beside the main program", name.text,
                      "give the name alone");
    double runs = 1;
    Program program;
    return times(runs) && cursor_.want_end() && find_program(plain_name(name.text), name_column, program) &&
           enter(program, {}, runs, name_column);
}

bool Interpreter::Machinery::refused_call(Block&, int column) {
    return refuse("NC0537", column, "calls of this kind are not carried out",
                  cursor_.line().substr(static_cast<std::size_t>(column - 1), 12), "CALL \"NAME\" is");
}

bool Interpreter::Machinery::return_statement(Block&, int column) {
    if (cursor_.sees("("))
        return refuse("NC0537", column, "RET with values goes back to other places: this is not carried out", "RET");
    leaving_ = true;
    return cursor_.want_end();
}

/// MCALL is for the reader, with the cycle behind it. Subprograms of one's own are not called that way here.
bool Interpreter::Machinery::modal_call(Block& block, int column) {
    if (!add_word(block, "MCALL", column)) return false;
    if (cursor_.at_end()) return true;
    const int next = cursor_.column();
    const std::string_view name = cursor_.peek_name();
    if (!name.empty() && is_word_(name)) return true;
    return refuse("NC0531", next, "not a cycle that is known here", name,
                  "modal calls of subprograms of one's own are not carried out: call it at every place");
}

}  // namespace trunnion::nc::sinumerik
