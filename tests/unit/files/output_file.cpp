#include "trunnion/files/output_file.hpp"

#include <algorithm>
#include <array>
#include <filesystem>

#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

namespace trunnion::files {
namespace {

class OutputFileTest : public testing::Test {
  protected:
    OutputFileTest()
        : folder_(std::filesystem::path(testing::TempDir()) / fmt::format("trunnion_output_file_{}", ::getpid())) {
        std::filesystem::remove_all(folder_);
        std::filesystem::create_directories(folder_);
    }
    ~OutputFileTest() override { std::filesystem::remove_all(folder_); }
    std::size_t files_there() const {
        return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
    }
    std::filesystem::path folder_;
};

TEST_F(OutputFileTest, appears_only_when_it_is_complete) {
    auto file = OutputFile::create(folder_ / "a.csv");
    ASSERT_TRUE(file);
    file->write("one\n");
    EXPECT_FALSE(std::filesystem::exists(folder_ / "a.csv"));
    file->write("two\n");
    ASSERT_TRUE(file->commit());
    EXPECT_EQ(read_whole_file(folder_ / "a.csv").value(), "one\ntwo\n");
    EXPECT_EQ(files_there(), 1u);
}

TEST_F(OutputFileTest, leaves_nothing_behind_without_commit) {
    {
        auto file = OutputFile::create(folder_ / "a.csv");
        file->write("half");
        auto moved = std::move(*file);
        moved.write(" of it");
    }
    EXPECT_EQ(files_there(), 0u);
}

TEST_F(OutputFileTest, keeps_the_old_file_until_the_new_one_is_complete) {
    auto first = OutputFile::create(folder_ / "a.csv");
    first->write("old");
    ASSERT_TRUE(first->commit());
    {
        auto second = OutputFile::create(folder_ / "a.csv");
        second->write("new");
    }
    EXPECT_EQ(read_whole_file(folder_ / "a.csv").value(), "old");
}

TEST_F(OutputFileTest, compresses_by_name_and_reads_it_back) {
    const std::string text(100000, 'x');
    auto file = OutputFile::create(folder_ / "a.csv.gz");
    file->write(text);
    ASSERT_TRUE(file->commit());
    EXPECT_LT(std::filesystem::file_size(folder_ / "a.csv.gz"), 2000u);
    EXPECT_EQ(read_whole_file(folder_ / "a.csv.gz").value(), text);
}

TEST_F(OutputFileTest, writes_to_a_pipe_as_it_is) {
    const auto pipe = folder_ / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
    auto file = OutputFile::create(pipe);
    ASSERT_TRUE(file);
    file->write("one\n");
    ASSERT_TRUE(file->commit());
    EXPECT_EQ(std::filesystem::status(pipe).type(), std::filesystem::file_type::fifo);
    char got[8] = {};
    EXPECT_EQ(::read(reader, got, sizeof got), 4);
    EXPECT_STREQ(got, "one\n");
    EXPECT_EQ(files_there(), 1U);
    ::close(reader);
}

TEST_F(OutputFileTest, has_no_name_until_it_is_complete) {
    auto file = OutputFile::create(folder_ / "a.csv");
    file->write(std::string(1 << 20, 'x'));
    EXPECT_EQ(files_there(), 0u);
    ASSERT_TRUE(file->commit());
    EXPECT_EQ(std::filesystem::file_size(folder_ / "a.csv"), 1u << 20);
}

/// What ends the program at once, at any moment, leaves no temporary name of a file that was not there before.
TEST_F(OutputFileTest, a_new_file_never_has_another_name) {
    const int watch = ::inotify_init1(IN_NONBLOCK);
    ASSERT_GE(::inotify_add_watch(watch, folder_.c_str(), IN_CREATE | IN_MOVE), 0);
    auto file = OutputFile::create(folder_ / "a.csv");
    file->write("one");
    ASSERT_TRUE(file->commit());
    alignas(inotify_event) std::array<char, 4096> bytes{};
    const auto got = static_cast<std::size_t>(std::max<ssize_t>(::read(watch, bytes.data(), bytes.size()), 0));
    ::close(watch);
    int names = 0;
    for (std::size_t at = 0; at < got; ++names) {
        const auto* const event = reinterpret_cast<const inotify_event*>(bytes.data() + at);
        EXPECT_STREQ(event->name, "a.csv");
        at += sizeof(inotify_event) + event->len;
    }
    EXPECT_EQ(names, 1);
}

TEST_F(OutputFileTest, takes_the_place_of_what_a_killed_program_left) {
    const auto left = folder_ / fmt::format("a.csv.{}.part", ::getpid());
    auto of_before = OutputFile::create(left);
    of_before->write("half");
    ASSERT_TRUE(of_before->commit());
    auto file = OutputFile::create(folder_ / "a.csv");
    file->write("whole");
    ASSERT_TRUE(file->commit());
    EXPECT_EQ(read_whole_file(folder_ / "a.csv").value(), "whole");
    EXPECT_EQ(files_there(), 1u);
}

TEST_F(OutputFileTest, has_the_permissions_of_new_files) {
    const auto before = ::umask(0027);
    auto file = OutputFile::create(folder_ / "a.csv");
    ASSERT_TRUE(file->commit());
    ::umask(before);
    EXPECT_EQ(static_cast<unsigned>(std::filesystem::status(folder_ / "a.csv").permissions()), 0640u);
}

TEST_F(OutputFileTest, a_folder_that_went_away_is_said) {
    std::filesystem::create_directory(folder_ / "sub");
    auto file = OutputFile::create(folder_ / "sub" / "a.csv");
    ASSERT_TRUE(file);
    file->write("lost");
    std::filesystem::remove_all(folder_ / "sub");
    EXPECT_EQ(file->commit().error().code, "FILE0202");
    EXPECT_EQ(files_there(), 0u);
}

TEST_F(OutputFileTest, says_what_cannot_be_written_or_read) {
    EXPECT_EQ(OutputFile::create(folder_ / "no/such/folder/a.csv").error().code, "FILE0201");
    EXPECT_EQ(read_whole_file(folder_ / "missing").error().code, "FILE0203");
    EXPECT_EQ(read_whole_file(folder_).error().code, "FILE0203");
    std::filesystem::create_directory(folder_ / "taken");
    EXPECT_EQ(OutputFile::create(folder_ / "taken").error().code, "FILE0201");
    EXPECT_EQ(files_there(), 1u);
}

}  // namespace
}  // namespace trunnion::files
