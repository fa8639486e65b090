// SPDX-License-Identifier: BSD-3-Clause
#include "tools/train_vocabulary/clustering.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>

#include "tests/unit/places/random_places.h"

namespace plslam::train_vocabulary {
namespace {

Descriptor SlowMajority(const std::vector<Descriptor>& descriptors) {
  Descriptor majority{};
  for (int bit = 0; bit < 256; ++bit) {
    int64_t ones = 0;
    for (const Descriptor& d : descriptors) ones += static_cast<int64_t>(d[bit / 64] >> (bit % 64) & 1U);
    if (2 * ones > static_cast<int64_t>(descriptors.size())) majority[bit / 64] |= uint64_t{1} << (bit % 64);
  }
  return majority;
}

TEST(MajorityVote, EqualsCountingBitByBit) {
  std::mt19937_64 random(1);
  for (const int count : {0, 1, 2, 3, 254, 255, 256, 511, 2000}) {
    const std::vector<Descriptor> descriptors = test::RandomDescriptors(count, random);
    MajorityVote vote;
    for (const Descriptor& d : descriptors) vote.Add(d);
    EXPECT_EQ(vote.count(), count);
    EXPECT_EQ(vote.Majority(), SlowMajority(descriptors)) << count << " descriptors";
  }
}

std::vector<int32_t> AllOf(const std::vector<Descriptor>& descriptors) {
  std::vector<int32_t> members(descriptors.size());
  std::iota(members.begin(), members.end(), 0);
  return members;
}

TEST(Clustering, FindsGroupsThatAreApart) {
  std::mt19937_64 random(2);
  const std::vector<Descriptor> centers = test::RandomDescriptors(5, random);
  std::vector<Descriptor> descriptors;
  for (int i = 0; i < 500; ++i) descriptors.push_back(test::Flip(centers[i % 5], 10, random));
  const auto clusters = ClusterDescriptors(descriptors, AllOf(descriptors), 5, 20, random);
  ASSERT_EQ(clusters.size(), 5U);
  for (const DescriptorCluster& cluster : clusters) {
    std::set<int32_t> groups;
    for (const int32_t member : cluster.members) groups.insert(member % 5);
    EXPECT_EQ(groups.size(), 1U);
    EXPECT_EQ(cluster.center, centers[*groups.begin()]);
  }
}

TEST(Clustering, EachMemberIsInTheNearestCluster) {
  std::mt19937_64 random(3);
  const std::vector<Descriptor> descriptors = test::RandomDescriptors(400, random);
  const auto clusters = ClusterDescriptors(descriptors, AllOf(descriptors), 8, 6, random);
  size_t members = 0;
  for (const DescriptorCluster& cluster : clusters) {
    members += cluster.members.size();
    EXPECT_FALSE(cluster.members.empty());
    for (const int32_t member : cluster.members) {
      for (const DescriptorCluster& other : clusters) {
        EXPECT_LE(HammingDistance(descriptors[member], cluster.center),
                  HammingDistance(descriptors[member], other.center));
      }
    }
  }
  EXPECT_EQ(members, descriptors.size());
}

TEST(Clustering, EqualDescriptorsAreOneCluster) {
  std::mt19937_64 random(4);
  const std::vector<Descriptor> descriptors(50, test::RandomDescriptor(random));
  const auto clusters = ClusterDescriptors(descriptors, AllOf(descriptors), 10, 5, random);
  ASSERT_EQ(clusters.size(), 1U);
  EXPECT_EQ(clusters[0].center, descriptors[0]);
}

TEST(Clustering, FewerDescriptorsThanClustersAndNone) {
  std::mt19937_64 random(5);
  const std::vector<Descriptor> descriptors = test::RandomDescriptors(3, random);
  EXPECT_EQ(ClusterDescriptors(descriptors, AllOf(descriptors), 10, 5, random).size(), 3U);
  EXPECT_TRUE(ClusterDescriptors(descriptors, {}, 10, 5, random).empty());
}

}  // namespace
}  // namespace plslam::train_vocabulary
