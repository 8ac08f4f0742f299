#include "pipeline/build/slice_choice.h"

#include "slim/base/error.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

namespace slim {
namespace {

/// An environment variable while it lives.
class Variable {
public:
    Variable(const char* name, const char* value) : name_(name) { ::setenv(name, value, 1); }
    ~Variable() { ::unsetenv(name_); }

private:
    const char* name_;
};

SlicePlan plan_of(std::size_t n) {
    SlicePlan plan;
    plan.slices.resize(n);
    return plan;
}

std::vector<std::size_t> slices(std::size_t n, int slice, int per_task) {
    SliceChoice choice;
    choice.slice = slice, choice.slices_per_task = per_task;
    return slices_to_do(choice, plan_of(n));
}

std::string refusal(std::size_t n, int slice, int per_task) {
    try {
        slices(n, slice, per_task);
        return "";
    } catch (const ConfigError& error) {
        return error.what();
    }
}

using Numbers = std::vector<std::size_t>;

TEST(SlicesToDo, ATaskOfAnArrayDoesItsOwn) {
    EXPECT_EQ(slices(3, -1, 1), (Numbers{0, 1, 2}));
    EXPECT_EQ(slices(3, 1, 1), (Numbers{1}));
    {
        const Variable task("PBS_ARRAY_INDEX", "1");
        EXPECT_EQ(slices(10, -1, 1), (Numbers{1}));
        EXPECT_EQ(slices(10, -1, 4), (Numbers{4, 5, 6, 7}));
        EXPECT_EQ(slices(10, kAllSlices, 1).size(), 10u);
        EXPECT_EQ(slices(10, 7, 1), (Numbers{7}));
    }
    const Variable task("SGE_TASK_ID", "3");  // from 1
    EXPECT_EQ(slices(10, -1, 4), (Numbers{8, 9}));
}

TEST(SlicesToDo, TasksTogetherDoAllOnce) {
    Numbers all;
    for (const char* index : {"0", "1", "2", "3"}) {
        const Variable task("SLURM_ARRAY_TASK_ID", index);
        const Numbers own = slices(11, -1, 3);
        all.insert(all.end(), own.begin(), own.end());
    }
    EXPECT_EQ(all, (Numbers{0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10}));
    const Variable task("SLURM_ARRAY_TASK_ID", "4");
    EXPECT_EQ(
        refusal(11, -1, 3),
        "task 4: at 3 slices a task the slices 0 to 10 of the plan are those of tasks 0 to 3");
}

TEST(SlicesToDo, AnIndexThatIsNoneIsRefusedByItsVariable) {
    for (const char* index : {"0abc", "abc", "-1", "1.5", " 1", "99999999999999999999"}) {
        const Variable task("PBS_ARRAY_INDEX", index);
        EXPECT_NE(refusal(3, -1, 1).find(std::string("PBS_ARRAY_INDEX=") + index + ":"),
                  std::string::npos)
            << index;
    }
    const Variable first("SGE_TASK_ID", "0");
    EXPECT_NE(refusal(3, -1, 1).find("SGE_TASK_ID=0"), std::string::npos);
    const Variable none("SGE_TASK_ID", "undefined");  // what SGE says outside of arrays
    EXPECT_EQ(slices(3, -1, 1).size(), 3u);
}

TEST(SlicesToDo, SlicesPerTaskIsForArrays) {
    EXPECT_NE(refusal(3, -1, 2).find("SLURM_ARRAY_TASK_ID"), std::string::npos);
    EXPECT_NE(refusal(3, 1, 2).find("leave out one"), std::string::npos);
}

}  // namespace
}  // namespace slim
