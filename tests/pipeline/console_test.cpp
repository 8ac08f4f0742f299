#include "pipeline/console.h"

#include "pipeline/memory_size.h"
#include "pipeline/plain_number.h"
#include "slim/base/error.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <string>

namespace slim {
namespace {

TEST(ProgressText, SaysShareRateAndTimeLeft) {
    EXPECT_EQ(progress_text("points", 250'000, 1'000'000, 1.0),
              "points 250 k of 1 M (25 %), 250 k/s, 0:03 left");
    EXPECT_EQ(progress_text("points", 100, 0, 2.0), "points 100, 50/s");
    EXPECT_EQ(progress_text("fits", 10, 10, 1.0), "fits 10 of 10 (100 %), 10/s");
    EXPECT_EQ(progress_text("fits", 1, 7201, 1.0), "fits 1 of 7201 (0 %), 1/s, 2:00:00 left");
}

TEST(ConsoleLog, QuietKeepsWarningsOnly) {
    testing::internal::CaptureStderr();
    {
        Console console("slim-x", Console::Level::quiet);
        console.info("hidden");
        console.progress("points", 1, 2);
        console.warn("seen");
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "slim-x: warning: seen\n");
}

TEST(ConsoleLog, AMessageIsOneLineWhateverAFileIsCalled) {
    testing::internal::CaptureStderr();
    Console console("slim-fit", Console::Level::normal);
    console.error("a\nb\x1b[2J.ply: cannot be opened");
    console.warn("c\td");
    EXPECT_EQ(testing::internal::GetCapturedStderr(),
              "slim-fit: error: a\\nb\\x1b[2J.ply: cannot be opened\n"
              "slim-fit: warning: c\\x09d\n");
}

TEST(ConsoleLog, VerboseAddsTheTime) {
    testing::internal::CaptureStderr();
    Console("slim-x", Console::Level::verbose).info("text");
    const std::string text = testing::internal::GetCapturedStderr();
    EXPECT_TRUE(text.starts_with("slim-x [0.0")) << text;
    EXPECT_TRUE(text.ends_with("s]: text\n")) << text;
}

TEST(ConsoleLog, ProgressOffATerminalIsSparse) {
    testing::internal::CaptureStderr();
    {
        Console console("slim-x", Console::Level::normal);
        for (std::uint64_t i = 0; i < 1000; ++i) console.progress("points", i, 1000);
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(MemorySize, ReadsUnits) {
    EXPECT_EQ(parse_memory_size("1048576"), 1u << 20);
    EXPECT_EQ(parse_memory_size("1GiB"), 1u << 30);
    EXPECT_EQ(parse_memory_size("512 MiB"), 512u << 20);
    EXPECT_EQ(parse_memory_size("2g"), 2ull << 30);
    EXPECT_EQ(parse_memory_size("1.5k"), 1536u);
    EXPECT_EQ(parse_memory_size("7B"), 7u);
    EXPECT_EQ(parse_memory_size("800MB"), 800ull << 20);
}

TEST(MemorySize, RefusesEverythingElse) {
    for (const char* text : {"", "GiB", "1X", "1GiBs", "-1G", "0", "1 G B", "nan", "1e30T", "1BiB"})
        EXPECT_THROW(parse_memory_size(text), ConfigError) << text;
}

TEST(MemorySize, PrintsForPeople) {
    EXPECT_EQ(memory_size_text(17), "17 B");
    EXPECT_EQ(memory_size_text(1536), "1.5 KiB");
    EXPECT_EQ(memory_size_text(1030000), "1006 KiB");
    EXPECT_EQ(memory_size_text(1023 << 20), "1023 MiB");
    EXPECT_EQ(memory_size_text(1ull << 30), "1 GiB");
}

TEST(PlainNumber, IsWrittenAsPeopleDo) {
    EXPECT_EQ(plain_number(1005.4, 3), "1005");
    EXPECT_EQ(plain_number(12.345, 3), "12.3");
    EXPECT_EQ(plain_number(-54321.9, 4), "-54322");
    EXPECT_EQ(plain_number(0.00012345, 3), "0.000123");
    EXPECT_EQ(plain_number(3e9, 3), "3e+09");
    EXPECT_EQ(duration_text(12.34), "12.3 ms");
    EXPECT_EQ(duration_text(999.7), "1 s");
    EXPECT_EQ(duration_text(1050), "1.05 s");
    EXPECT_EQ(duration_text(1234567), "1235 s");
}

}  // namespace
}  // namespace slim
