#include "pipeline/job/makefile.h"

#include "tests/pipeline/job/job_support.h"

#include <gtest/gtest.h>

#include <string>

namespace slim::test {
namespace {

TEST(Makefile, NamesEveryStepsOutputAndWhatItNeeds) {
    const Job job = read_job(write_job(kDemo));
    const std::string text = makefile_of(job, "/opt/a b");
    const std::string folder = job.folder.string();
    EXPECT_NE(
        text.find(folder + "/model.slim.work/slice.done.json: " + folder + "/cloud.ply.done.json"),
        std::string::npos);
    EXPECT_NE(text.find(folder + "/front.png.done.json: " + folder + "/model.slim.done.json"),
              std::string::npos);
    EXPECT_NE(text.find("$(wildcard " + folder + "/front.k1.png)"), std::string::npos);
    EXPECT_NE(text.find("'/opt/a b/slim-build' '" + folder + "/cloud.ply' '--degree=3'"),
              std::string::npos);
    EXPECT_NE(text.find("\nall: " + folder + "/run.done.json\n"), std::string::npos);
    EXPECT_NE(text.find("\ninclude " + folder + "/.make/slices.mk\n"), std::string::npos);
}

TEST(Makefile, HasARuleForEachSlice) {
    const Job job = read_job(write_job(kDemo));
    SlicePlan plan;
    plan.slices.resize(3);
    plan.has_normals = true;
    const std::string work = job.folder.string() + "/model.slim.work/";
    const std::string normals_1 = work + "slice_0001/oriented.slice.done.json: ";
    const std::string normals_0 = work + "slice_0000/oriented.slice.done.json ";
    const std::string free = slice_rules_of(job, plan, "/bin");
    EXPECT_NE(free.find(normals_1 + work + "slice.done.json"), std::string::npos);
    EXPECT_EQ(free.find(normals_1 + work + "slice.done.json " + normals_0), std::string::npos);
    EXPECT_NE(free.find("'--degree=3' '--coarse'"), std::string::npos);
    for (const char* slice :
         {"'--degree=3' '--slice=0'", "'--degree=3' '--slice=1'", "'--degree=3' '--slice=2'"})
        EXPECT_NE(free.find(slice), std::string::npos) << slice;
    // Estimated normals take their signs from the slice before.
    plan.has_normals = false;
    const std::string in_order = slice_rules_of(job, plan, "/bin");
    EXPECT_NE(in_order.find(normals_1 + work + "slice.done.json " + normals_0), std::string::npos);
    plan.slices.resize(1);
    EXPECT_EQ(slice_rules_of(job, plan, "/bin").find("--coarse"), std::string::npos);
}

/// The Makefile of a job in a folder of that name, "PATH" for its path as the file has it.
std::string makefile_in(const std::string& name) {
    Job job = read_job(write_job(kDemo));
    job.steps.resize(1);
    job.steps[0].verb = "scan";
    job.steps[0].target = "/w/" + name + "/cloud.done.json";
    job.steps[0].inputs = {"/w/" + name + "/in"};
    job.folder = "/w/" + name;
    return makefile_of(job, "/bin");
}

TEST(Makefile, NamesAreWrittenAsMakeReadsThemInEachPlace) {
    // As a target a bare % is a pattern; as a prerequisite a quoted one keeps its backslash.
    const std::string percent = makefile_in("a%b");
    EXPECT_NE(percent.find("\n/w/a\\%b/cloud.done.json: /w/a%b/in"), std::string::npos) << percent;
    EXPECT_NE(percent.find("\ninclude /w/a%b/.make/slices.mk\n"), std::string::npos);
    EXPECT_NE(makefile_in("a:b").find("\ninclude /w/a:b/.make/slices.mk\n"), std::string::npos);
    EXPECT_NE(makefile_in("a:b").find("\n/w/a\\:b/cloud.done.json: /w/a\\:b/in"),
              std::string::npos);
    EXPECT_NE(makefile_in("a=b").find("\n/w/a$(equals)b/cloud.done.json: "), std::string::npos);
    EXPECT_NE(makefile_in("a$ #b").find("\n/w/a$$\\ \\#b/cloud.done.json: "), std::string::npos);
}

TEST(Makefile, WhatMakeCannotNameIsRefused) {
    for (const char* name : {"a|b", "a;b", "a\\b", "a\nb"})
        EXPECT_THROW(makefile_in(name), ConfigError) << name;
}

}  // namespace
}  // namespace slim::test
