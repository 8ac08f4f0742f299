#include "pipeline/job/index_page.h"

#include "tests/pipeline/job/job_support.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace slim::test {
namespace {

TEST(IndexPage, ShowsFiguresCostsAndPicturesRelatively) {
    const Job job = read_job(write_job(kDemo));
    std::vector<StepOutcome> outcomes;
    for (const JobStep& step : job.steps)
        outcomes.push_back({step, nlohmann::json::object(), false, 1.25, 2e6});
    outcomes[1].result = {{"points", 1000u}, {"leaves", 1234567u}, {"bytes", 2048u},
                          {"stages", {{"fit", {{"seconds", 0.5}, {"peak_memory_bytes", 1e6}}}}}};
    outcomes[2].result = {{"l2", 1.5e-4}, {"normal_rms_deg", 2.5}};
    outcomes[3].result = {{"files", {(job.folder / "front.shaded.png").string(),
                                     (job.folder / "front.k1.png").string(),
                                     (job.folder / "front.k1.legend.svg").string(),
                                     (job.folder / "front.lines.svg").string()}}};
    outcomes[0].up_to_date = true;
    const std::string page = index_page(job, outcomes);
    for (const char* part : {"1,234,567", "2 KiB", "0.00015", "src=\"front.shaded.png\"",
                             "src=\"front.k1.png\"", "1.25", "&emsp;fit", "up to date"})
        EXPECT_NE(page.find(part), std::string::npos) << part;
    EXPECT_EQ(page.find("legend.svg"), std::string::npos);
    // Drawings are linked below the pictures, which share the width between them and are not blown
    // up.
    EXPECT_LT(page.find("src=\"front.k1.png\""),
              page.find("</div>\n<p class=\"note\"><a href=\"front.lines.svg\">"));
    EXPECT_NE(page.find("auto-fit"), std::string::npos);
    EXPECT_NE(page.find("figure img { max-width: 100%"), std::string::npos);
    EXPECT_EQ(page.find(job.folder.string()), std::string::npos);
}

}  // namespace
}  // namespace slim::test
