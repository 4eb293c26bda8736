#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "detail/fanuc_interpreter.hpp"

namespace trunnion::nc::fanuc {

namespace {

constexpr double most_repeats = 9999, largest_program = 99999999;
constexpr double short_number = 10000;  ///< M98 P51234: the last four digits are the program, those before them L

/// The local variable of a letter behind G65; 0: none.
int variable_of(char letter) {
    constexpr std::string_view letters = "ABCIJKDEF-H-M---QRSTUVWXYZ";
    const std::size_t at = letters.find(letter);
    return at == letters.npos ? 0 : static_cast<int>(at) + 1;
}

bool is_whole(double value, double most) {
    return value >= 0 && value <= most && value == std::floor(value);
}

}  // namespace

/// Takes the words of a call out of the block; the call follows when the rest of the block is carried out.
bool Interpreter::find_call(Block& block) {
    for (std::size_t i = 0; i < block.words.size(); ++i) {
        const Word& word = block.words[i];
        if (word.letter != 'G' && word.letter != 'M') continue;
        const double number = word.value;
        if (word.letter == 'G' && (number == 65 || number == 66)) return macro_call(block, i, number == 66);
        if (word.letter == 'G' && number == 67) {
            modal_.reset();
            block.words.erase(block.words.begin() + static_cast<std::ptrdiff_t>(i));
            return true;
        }
        if (word.letter == 'M' && number >= 97 && number <= 99) {
            Call call{.spot = block.spot(word)};
            call.kind = number == 97   ? Call::Kind::local
                        : number == 98 ? Call::Kind::subprogram
                                       : Call::Kind::give_back;
            block.words.erase(block.words.begin() + static_cast<std::ptrdiff_t>(i));
            std::erase_if(block.words, [&](const Word& other) {
                if (other.letter == 'P') call.program = other.value;
                if (other.letter == 'L') call.repeats = other.value;
                return other.letter == 'P' || other.letter == 'L';
            });
            pending_ = std::move(call);
            return true;
        }
    }
    return true;
}

/// G65 and G66 with the arguments behind them. I J K may be repeated: #4 #5 #6, then #7 #8 #9 and so on.
bool Interpreter::macro_call(Block& block, std::size_t at, bool modal) {
    Call call{.kind = Call::Kind::macro, .modal = modal, .spot = block.spot(block.words[at])};
    int group = 0, last = -1;
    for (std::size_t i = at + 1; i < block.words.size(); ++i) {
        const Word& word = block.words[i];
        if (word.letter == 'P') {
            call.program = word.value;
        } else if (word.letter == 'L') {
            call.repeats = word.value;
        } else if (word.letter >= 'I' && word.letter <= 'K') {
            const int place = word.letter - 'I';
            if (place <= last && ++group > 9)
                return refuse("NC0809", block.spot(word), "I J K more than ten times in a call");
            last = place;
            call.arguments.push_back({4 + 3 * group + place, word.value});
        } else if (const int variable = variable_of(word.letter)) {
            call.arguments.push_back({variable, word.value});
        } else {
            return refuse("NC0809", block.spot(word), "this letter is no argument of a macro",
                          std::string_view(&word.letter, 1));
        }
    }
    block.words.resize(at);
    if (!call.program) return refuse("NC0809", call.spot, "a call without its program", {}, "P and its number");
    if (modal)
        modal_ = std::move(call);
    else
        pending_ = std::move(call);
    return true;
}

void Interpreter::moved() {
    const bool within = std::ranges::any_of(running_, &Running::modal);
    if (modal_ && !within && !pending_) pending_ = modal_;
}

Interpreter::Outcome Interpreter::carry_out(const Call& call) {
    if (call.program && !is_whole(*call.program, largest_program))
        return refused("NC0809", call.spot, "P of a call is a whole number", fmt::format("P{}", *call.program));
    if (call.repeats && (!is_whole(*call.repeats, most_repeats) || *call.repeats == 0))
        return refused("NC0809", call.spot, "L of a call is a whole number from 1 to 9999",
                       fmt::format("L{}", *call.repeats));
    if (call.kind != Call::Kind::give_back) return call_program(call);
    const auto to_block = call.program ? std::optional(static_cast<int>(*call.program)) : std::nullopt;
    if (running_.size() > 1) return give_back(to_block);
    if (to_block) return jump(*to_block, call.spot) ? Outcome::nothing : Outcome::refused;
    findings_.count("NC0867", Severity::note, call.spot, "M99",
                    "M99 would begin the main program again: it is read once");
    return Outcome::section_end;
}

Interpreter::Outcome Interpreter::call_program(const Call& call) {
    if (!call.program) {
        if (call.kind == Call::Kind::local) return Outcome::nothing;  // FANUC's M97 ends macro interrupts
        return refused("NC0809", call.spot, "a call without its program", {}, "P and its number");
    }
    if (running_.size() > limits_.calls)
        return refused("NC0807", call.spot, fmt::format("more than {} calls within each other", limits_.calls), {},
                       "a program that calls itself?");
    double number = *call.program;
    int repeats = static_cast<int>(call.repeats.value_or(1));
    if (call.kind == Call::Kind::subprogram && !call.repeats && number >= short_number) {
        repeats = static_cast<int>(number / short_number);
        number = std::fmod(number, short_number);
        if (repeats > most_repeats)
            return refused("NC0809", call.spot, "P of M98: up to four digits of repeats, then four of the program",
                           fmt::format("P{}", *call.program));
    }
    if (call.kind == Call::Kind::local) {
        Running& running = now();
        const auto& labels = running.source->labels(running.section, static_cast<int>(number));
        if (labels.empty())
            return refused("NC0804", call.spot, "no block of this program has the sequence number",
                           fmt::format("N{}", number));
        enter(call, *running.source, Section(running.section), labels.front(), repeats);
        return Outcome::nothing;
    }
    Source* source = nullptr;
    Section section;
    if (!program_of(call, static_cast<int>(number), source, section)) return Outcome::refused;
    enter(call, *source, section, section.begin, repeats);
    return Outcome::nothing;
}

/// In the text that is read, in the files that were read before, in the folder.
bool Interpreter::program_of(const Call& call, int number, Source*& source, Section& section) {
    const std::string name = fmt::format("O{:04}", number);
    if (const Section* found = main_.section(number)) {
        source = &main_;
        section = *found;
        return true;
    }
    auto known = std::ranges::find(files_, number, &std::pair<int, std::unique_ptr<Source>>::first);
    if (known == files_.end()) {
        std::unique_ptr<Source> file;
        switch (folder_.read(number, file)) {
            case Folder::Found::file:
                files_.emplace_back(number, std::move(file));
                known = files_.end() - 1;
                break;
            case Folder::Found::nothing:
                return refuse("NC0806", call.spot, "no such subprogram in the program or beside its file", name,
                              "put it into the same folder, as " + name);
            case Folder::Found::several:
                return refuse("NC0810", call.spot, "several files could be this subprogram", name, "leave one of them");
            case Folder::Found::outside:
                return refuse("NC0810", call.spot, "the subprogram's file lies outside the program's folder", name);
            case Folder::Found::unreadable:
                return refuse("NC0810", call.spot, "the subprogram's file cannot be read", name);
        }
    }
    source = known->second.get();
    const Section* const titled = source->section(number);
    section = titled ? *titled : source->main_section();
    return true;
}

void Interpreter::enter(const Call& call, Source& source, const Section& section, Place at, int repeats) {
    running_.push_back({.source = &source,
                        .section = section,
                        .start = at,
                        .at = at,
                        .repeats = repeats,
                        .own_parameters = call.kind == Call::Kind::macro,
                        .modal = call.modal,
                        .arguments = call.arguments});
    if (now().own_parameters) {
        parameters_.enter();
        set_arguments(now());
    }
}

void Interpreter::set_arguments(const Running& running) {
    for (const Argument& argument : running.arguments) parameters_.set({.number = argument.variable}, argument.value);
}

/// M99: the next repeat, or back behind the call; with P: to a block of the caller.
Interpreter::Outcome Interpreter::give_back(std::optional<int> to_block) {
    Running& running = now();
    if (running.own_parameters) parameters_.leave();
    if (!to_block && --running.repeats > 0) {
        running.at = running.start;
        running.fresh = true;
        running.loops.clear();
        if (running.own_parameters) {
            parameters_.enter();
            set_arguments(running);
        }
        return Outcome::nothing;
    }
    running_.pop_back();
    if (to_block && !jump(*to_block, cursor_.spot())) return Outcome::refused;
    return Outcome::nothing;
}

}  // namespace trunnion::nc::fanuc
