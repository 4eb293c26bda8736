#include "detail/blob.hpp"

#include <cstring>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <zlib.h>

namespace trunnion::report::detail {
namespace {

std::string inflated(const std::string& bytes, std::size_t size) {
    std::string out(size, '\0');
    z_stream stream{};
    inflateInit2(&stream, -15);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
    stream.avail_in = static_cast<uInt>(bytes.size());
    stream.next_out = reinterpret_cast<Bytef*>(out.data());
    stream.avail_out = static_cast<uInt>(out.size());
    EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
    EXPECT_EQ(stream.total_out, size);
    inflateEnd(&stream);
    return out;
}

TEST(Base64, VectorsOfRfc4648) {
    EXPECT_EQ(base64(""), "");
    EXPECT_EQ(base64("f"), "Zg==");
    EXPECT_EQ(base64("fo"), "Zm8=");
    EXPECT_EQ(base64("foo"), "Zm9v");
    EXPECT_EQ(base64("foob"), "Zm9vYg==");
    EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
    EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
    EXPECT_EQ(base64("\xff\xfe\x00"), "//4=");
    EXPECT_EQ(base64(std::string_view("\xff\xfe\x00", 3)), "//4A");
}

TEST(Blob, ColumnsBeginAtMultiplesOfEightAndComeBack) {
    Blob blob;
    const std::vector<std::uint8_t> bytes{1, 2, 3};
    const std::vector<double> numbers{-1.5, 1e300};
    const auto first = blob.add(std::span<const std::uint8_t>(bytes));
    const auto second = blob.add(std::span<const double>(numbers));
    EXPECT_EQ(first.offset, 0U);
    EXPECT_STREQ(first.type, "u8");
    EXPECT_EQ(second.offset, 8U);
    EXPECT_EQ(second.count, 2U);
    EXPECT_STREQ(second.type, "f64");
    const std::string back = inflated(blob.deflated(), blob.size());
    EXPECT_EQ(back.substr(0, 3), std::string("\1\2\3"));
    double read = 0;
    std::memcpy(&read, back.data() + 16, sizeof read);
    EXPECT_EQ(read, 1e300);
}

TEST(Blob, EmptyOneIsDeflatedToo) {
    EXPECT_EQ(inflated(Blob().deflated(), 0), "");
}

}  // namespace
}  // namespace trunnion::report::detail
