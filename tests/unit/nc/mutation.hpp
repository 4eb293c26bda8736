#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "trunnion/nc/read.hpp"

#include "random.hpp"
#include "sound.hpp"

namespace trunnion::nc {

/// Good programs of a dialect, and what is thrown into them.
struct Mutations {
    std::uint64_t seed;
    int count;
    std::span<const std::string_view> programs, pieces;
    int least_read = 300, least_refused = 300;
};

/// One to four times: a piece put in, some characters taken out, the end cut off, a part said again, a line put in, a
/// character changed.
inline std::string mutated(std::string text, std::span<const std::string_view> pieces, Random& random) {
    for (std::size_t changes = 1 + random.below(4); changes > 0; --changes) {
        const std::size_t at = random.below(text.size() + 1);
        const std::size_t kind = random.below(6);
        const std::size_t amount = 1 + random.below(9);
        const std::size_t line = text.find('\n', at);
        if (kind == 0) text.insert(at, pieces[random.below(pieces.size())]);
        if (kind == 1) text.erase(at, amount);
        if (kind == 2) text.resize(at);
        if (kind == 3) text.insert(at, text.substr(random.below(text.size() + 1), 4 * amount));
        if (kind == 4)
            text.insert(line == text.npos ? at : line + 1, std::string(pieces[random.below(pieces.size())]) + "\n");
        if (kind == 5 && at < text.size()) text[at] = static_cast<char>(random.below(256));
    }
    return text;
}

/// Every text is read as something sound or refused with a code. `read` takes a text and options, `check` what was
/// read.
template <class Read, class Check>
void expect_read_or_refused(const Mutations& mutations, Read read, Check check) {
    SCOPED_TRACE(mutations.seed);
    testing::Test::RecordProperty("seed", std::to_string(mutations.seed));
    Random random{mutations.seed};
    int good = 0, refused = 0;
    for (int i = 0; i < mutations.count; ++i) {
        const std::string_view program = mutations.programs[random.below(mutations.programs.size())];
        const std::string text = mutated(std::string(program), mutations.pieces, random);
        ReadOptions options;
        options.feed_given_elsewhere = random.below(2) == 0;
        options.most_repeated_lines = 5000;
        const auto answer = read(text, options, random);
        SCOPED_TRACE(text);
        if (answer)
            check(*answer);
        else
            ASSERT_TRUE(answer.error().code.starts_with("NC0") && !answer.error().text.empty());
        if (testing::Test::HasFatalFailure()) return;
        ++(answer ? good : refused);
    }
    EXPECT_GT(good, mutations.least_read) << "the mutations should leave some programs readable";
    EXPECT_GT(refused, mutations.least_refused);
}

/// Rapids have no feed, all other moves have one.
inline void expect_sound_with_feeds(const program::Program& program) {
    expect_sound(program);
    for (const program::Move& move : program.moves)
        ASSERT_EQ(move.feed.rule == program::FeedRule::none, move.kind == program::MoveKind::rapid);
}

}  // namespace trunnion::nc
