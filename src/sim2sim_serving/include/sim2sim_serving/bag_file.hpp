// SPDX-License-Identifier: BSD-3-Clause
/// Bags: one that is complete or absent, and reading of one that may be damaged.
#pragma once

#include <ros/message_traits.h>
#include <ros/time.h>
#include <rosbag/bag.h>
#include <rosbag/message_instance.h>

#include <boost/make_shared.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "pusht_task/error.hpp"
#include "pusht_task/files.hpp"

namespace pusht {

/// Bag that is written aside, as AsideFile, and appears at its path when it is finished, or not at all. A killed
/// process leaves PATH.part, from which `rosbag reindex` recovers the written messages.
class BagFile {
 public:
  /// Throws InvalidInput if there is something at `path` already, RuntimeFault if the bag cannot be written.
  explicit BagFile(std::filesystem::path path);
  BagFile(const BagFile&) = delete;
  BagFile& operator=(const BagFile&) = delete;
  ~BagFile();

  /// Writes a message. Throws RuntimeFault if the bag cannot be written.
  template <class Message>
  void write(const std::string& topic, const ros::Time& stamp, const Message& message) {
    attempt([&] { bag_->write(topic, stamp, message); });
  }

  /// Writes a message, as write(), on a topic that is latched when the bag is played.
  template <class Message>
  void writeLatched(const std::string& topic, const ros::Time& stamp, const Message& message) {
    const auto header = boost::make_shared<ros::M_string>();
    (*header)["type"] = ros::message_traits::datatype(message);
    (*header)["md5sum"] = ros::message_traits::md5sum(message);
    (*header)["message_definition"] = ros::message_traits::definition(message);
    (*header)["latching"] = "1";
    attempt([&] { bag_->write(topic, stamp, message, header); });
  }

  /// Closes the bag and moves it to its path. Throws RuntimeFault if that fails; nothing is left then.
  void finish();

 private:
  void close();
  void attempt(const std::function<void()>& action) const;

  std::filesystem::path path_;
  AsideFile file_;  // the bag opens it by its name
  std::unique_ptr<rosbag::Bag> bag_;
};

/// Reads the bag at `path` by `work`. Throws InvalidInput, naming the bag, if there is no file or it is no whole bag;
/// RuntimeFault if the disk is at fault; an Error of `work` with the bag in front.
void readBag(const std::filesystem::path& path, const std::function<void(const rosbag::Bag&)>& work);

/// Message of a bag. Throws InvalidInput if it is of another type, or of that type in another version.
template <class Message>
Message messageIn(const rosbag::MessageInstance& instance) {
  const boost::shared_ptr<Message> message = instance.instantiate<Message>();
  if (message == nullptr) {
    throw InvalidInput(instance.getTopic() + " is " + instance.getDataType() + ", must be " +
                       ros::message_traits::datatype<Message>() + " as it is now");
  }
  return *message;
}

}  // namespace pusht
