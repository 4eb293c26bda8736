#include "detail/gzip.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

#include <gtest/gtest.h>
#include <unistd.h>
#include <zlib.h>

#include "joined.hpp"

namespace trunnion::nc {
namespace {

std::string packed(std::string_view text) {
    z_stream stream{};
    EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, 15 + 16, 8, Z_DEFAULT_STRATEGY), Z_OK);
    std::string archive(deflateBound(&stream, static_cast<uLong>(text.size())) + 64, '\0');
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(text.data()));
    stream.avail_in = static_cast<uInt>(text.size());
    stream.next_out = reinterpret_cast<Bytef*>(archive.data());
    stream.avail_out = static_cast<uInt>(archive.size());
    EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
    archive.resize(stream.total_out);
    deflateEnd(&stream);
    return archive;
}

constexpr std::size_t plenty = 1 << 30;

/// What an archive holds, which is given in pieces of 1000 bytes.
Result<std::string> inflated(std::string_view archive, std::size_t most) {
    std::string text;
    const auto source = [&](std::span<char> into) {
        const std::size_t count = archive.copy(into.data(), std::min<std::size_t>(into.size(), 1000));
        archive.remove_prefix(count);
        return count;
    };
    const auto whole = inflate_archive(source, most, [&](std::string_view bytes) {
        text += bytes;
        return true;
    });
    if (!whole) return fail(whole.error());
    return text;
}

TEST(Gzip, ComesBackWhole) {
    for (const std::size_t size : {0u, 1u, 1'000u, (1u << 20) - 1, 1u << 20, (1u << 20) + 1, 5'000'000u}) {
        std::string text(size, 'G');
        for (std::size_t i = 0; i < size; i += 7) text[i] = static_cast<char>('0' + (i * i) % 10);
        const auto back = inflated(packed(text), plenty);
        ASSERT_TRUE(back) << size;
        EXPECT_TRUE(*back == text) << size;
    }
    const auto members = inflated(packed("G0 X0\n") + packed("G0 X1\n") + std::string(512, '\0'), plenty);
    ASSERT_TRUE(members);
    EXPECT_EQ(*members, "G0 X0\nG0 X1\n");
}

TEST(Gzip, DamageIsRefused) {
    std::string text;
    for (int i = 0; i < 20'000; ++i) text += std::to_string(i * 7919 % 100'003);
    const std::string archive = packed(text);
    for (std::size_t length = 2; length < archive.size(); length += 997)
        EXPECT_EQ(inflated(archive.substr(0, length), plenty).error().code, "NC0009") << length;
    std::string wrong = archive;
    wrong[wrong.size() / 2] = static_cast<char>(wrong[wrong.size() / 2] ^ 0x55);
    EXPECT_EQ(inflated(wrong, plenty).error().code, "NC0009");
    EXPECT_EQ(inflated(archive + "GARBAGE", plenty).error().code, "NC0009");
}

TEST(Gzip, NoMoreThanIsAllowed) {
    const std::string archive = packed(std::string(10'000'000, '0'));
    ASSERT_LT(archive.size(), 20'000u);
    EXPECT_EQ(inflated(archive, 9'999'999).error().code, "NC0008");
    EXPECT_TRUE(inflated(archive, 10'000'000));
}

TEST(Gzip, APackedProgramIsReadAsTheProgram) {
    const auto file = std::filesystem::temp_directory_path() / "trunnion_gzip_test.ngc.gz";
    std::ofstream(file, std::ios::binary) << packed("G21 G0 X0 Y0 Z0\nG1 X5 F100\n");
    const auto p = read_program_file(file, {});
    ASSERT_TRUE(p) << said(p);
    EXPECT_EQ(p->moves.back().position_mm.x(), 5);
    std::ofstream(file, std::ios::binary) << "\x1f\x8b";
    const auto broken = read_program_file(file, {});
    ASSERT_FALSE(broken);
    EXPECT_EQ(broken.error().code, "NC0009");
    EXPECT_EQ(broken.error().place.file, file.string());
    std::filesystem::remove(file);
}

TEST(Gzip, PartsOfAPackedProgramAreThoseOfTheProgram) {
    std::string text = "G21 G0 X0 Y0 Z0 F100\n";
    for (int i = 0; i < 20'000; ++i) text += fmt::format("G{} X{} Y{}\n", i % 50 == 0 ? 0 : 1, i * 7919 % 1009, i);
    const FileForTest packed_file("packed.ngc.gz", packed(text)), file("packed.ngc", text);
    ReadOptions options;
    options.parts.to_rapid = 1000;
    const JoinedParts read = join_parts(packed_file.path(), options), plain = join_parts(file.path(), options);
    ASSERT_FALSE(read.error) << to_string(*read.error);
    EXPECT_EQ(read.parts.size(), 20u);
    EXPECT_TRUE(read.joined == plain.joined);
    const FileForTest cut("cut.ngc.gz", std::string_view(packed(text)).substr(0, 20'000));
    EXPECT_EQ(open_program_file(cut.path(), options).error().code, "NC0009");
}

}  // namespace
}  // namespace trunnion::nc
