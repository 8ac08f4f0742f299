#include "pipeline/job/view_shares.h"

#include "tests/pipeline/job/job_support.h"

#include <gtest/gtest.h>

#include <set>
#include <string>

namespace slim::test {
namespace {

JobStep view_of(const std::string& keys, const std::string& render = "") {
    const Job job = read_job(write_job("[input]\nfiles = ['a.ply']\n[render]\n" + render +
                                       "\n[[view]]\nname = 'v'\n" + keys));
    return job.steps.back();
}

std::string explained(const std::string& keys) {
    return explanation_of(
        read_job(write_job("[input]\nfiles = ['a.ply']\n[[view]]\nname = 'v'\n" + keys)));
}

TEST(ViewShares, SmallViewsAreOneTask) {
    EXPECT_TRUE(view_of("").shares.empty());
    EXPECT_TRUE(view_of("size = '4096x4096'").shares.empty());
    EXPECT_TRUE(view_of("turntable = 36\nsize = '800x600'").shares.empty());
    EXPECT_EQ(explained("size = '4096x4096'").find("in plans"), std::string::npos);
}

TEST(ViewShares, LargeOnesAreDividedByTheirPixels) {
    // 128 million a task: 72 x 1600 x 1200 are 138 million.
    EXPECT_EQ(view_of("turntable = 66").shares.size(), 0u);
    EXPECT_EQ(view_of("turntable = 72").shares.size(), 2u);
    EXPECT_EQ(view_of("turntable = 72\naovs = ['shaded', 'mean']").shares.size(), 3u);
    EXPECT_EQ(view_of("turntable = 72\nsupersample = 2").shares.size(), 5u);
    EXPECT_EQ(view_of("turntable = 72\nantialias = true").shares.size(), 3u);
    EXPECT_EQ(view_of("turntable = 72\nmode = 'raytrace'").shares.size(), 9u);
    EXPECT_EQ(view_of("size = '16384x16384'").shares.size(), 3u);
    // No more than there are pictures, or blocks of 256 rows.
    EXPECT_EQ(view_of("turntable = 2\nsize = '16384x16384'").shares.size(), 2u);
    EXPECT_EQ(view_of("size = '4096x512'\nmode = 'raytrace'\nsupersample = 2\naovs = "
                      "['shaded', 'ao', 'normal', 'depth']")
                  .shares.size(),
              2u);
    EXPECT_NE(explained("turntable = 72")
                  .find("in plans 2 tasks and one that joins: 138 million pixels at up to 128 "
                        "million a task"),
              std::string::npos);
}

TEST(ViewShares, OnePictureWithLinesIsNotDividedByItself) {
    const std::string keys = "size = '16384x16384'\nlines = ['contour']\n";
    EXPECT_TRUE(view_of(keys).shares.empty());
    EXPECT_NE(explained(keys).find("in plans one task: 268 million"), std::string::npos);
    EXPECT_NE(explained(keys).find("shares = n divides it"), std::string::npos);
    EXPECT_EQ(view_of(keys + "shares = 4").shares.size(), 4u);
    EXPECT_EQ(view_of("turntable = 72\nlines = ['contour']").shares.size(), 2u);
}

TEST(ViewShares, TheJobsNumberWins) {
    EXPECT_EQ(view_of("shares = 3").shares.size(), 3u);
    EXPECT_TRUE(view_of("turntable = 720\nshares = 1").shares.empty());
    EXPECT_EQ(view_of("", "shares = 4").shares.size(), 4u);
    EXPECT_EQ(view_of("shares = 2", "shares = 4").shares.size(), 2u);
    EXPECT_NE(explained("shares = 3").find("in plans 3 tasks and one that joins: shares = 3"),
              std::string::npos);
    // What draws is told by the plan alone.
    for (const std::string& argument : view_of("shares = 3").arguments)
        EXPECT_EQ(argument.find("shares"), std::string::npos);
}

TEST(ViewShares, WhatCannotBeDividedIsRefusedWithItsLine) {
    const std::string start = "[input]\nfiles = ['a.ply']\n[[view]]\nshares = 4\n";
    const auto says = [&](const std::string& keys, const char* message) {
        const std::string text = refusal(start + keys);
        EXPECT_NE(text.find(message), std::string::npos) << text;
        EXPECT_NE(text.find("job.toml:4: "), std::string::npos) << text;
    };
    says("turntable = 3", "at most 3 shares");
    says("crop = '0,0,10,10'", "leave out crop");
    says("turntable = 9\nframe = 2", "leave out frame");
    // A part by itself is one task.
    EXPECT_TRUE(view_of("turntable = 720\nframe = 3").shares.empty());
    EXPECT_TRUE(view_of("size = '16384x16384'\ntile = '1/3'").shares.empty());
    EXPECT_NE(refusal("[input]\nfiles = ['a.ply']\n[[view]]\nshare = '1/2'\n").find("unknown key"),
              std::string::npos);
}

TEST(ViewShares, WhatNoViewTakesOfAllIsUnknown) {
    for (const char* key : {"name = 'x'", "aovs = ['mean']", "join = 2"}) {
        const std::string text =
            refusal(std::string("[input]\nfiles = ['a.ply']\n[render]\n") + key + "\n[[view]]\n");
        EXPECT_NE(text.find("job.toml:4: unknown key"), std::string::npos) << text;
    }
}

TEST(ViewShares, KnowWhatEachLeaves) {
    const JobStep film =
        view_of("turntable = 5\nshares = 2\naovs = ['shaded', 'mean']\nlines = ['contour']");
    std::multiset<std::filesystem::path> of_shares;
    for (const JobShare& share : film.shares)
        of_shares.insert(share.products.begin(), share.products.end());
    EXPECT_EQ(of_shares,
              std::multiset<std::filesystem::path>(film.products.begin(), film.products.end()));
    EXPECT_EQ(film.shares[0].products.size(), 6u);  // pictures 1 and 2, three files each
    EXPECT_EQ(film.shares[1].option, "--share=2/2");
    EXPECT_EQ(film.shares[1].target.string(),
              film.output.string() + ".shares/0002_of_0002.done.json");
    const JobStep picture = view_of("shares = 2\naovs = ['mean']\nlines = ['contour']");
    const std::string folder = picture.output.string() + ".shares/0002_of_0002/";
    ASSERT_EQ(picture.shares[1].products.size(), 1u);
    EXPECT_EQ(picture.shares[1].products[0], folder + "v.mean.png");
    EXPECT_EQ(picture.shares[0].products.size(), 2u);  // and the lines
}

}  // namespace
}  // namespace slim::test
