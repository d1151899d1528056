"""Writes the same 36 samples of an IMU in each format, by the tools that users have.

    python -m venv env && env/bin/pip install numpy scipy h5py lz4 mcap-ros2-support pyarrow rosbags zstandard
    env/bin/python tests/data/formats/make.py
"""

import gzip
import sqlite3
import struct
from pathlib import Path

import h5py
import lz4.frame
import numpy as np
import pyarrow
import pyarrow.parquet
import scipy.io
import zstandard
from mcap_ros2.writer import Writer as Mcap
from rosbags.rosbag1 import Writer as Bag
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

FOLDER = Path(__file__).parent
COUNT = 36
STEP_NS = 5_000_000
START_NS = 1_700_000_000_000_000_000
IMU = """std_msgs/Header header
geometry_msgs/Quaternion orientation
float64[9] orientation_covariance
geometry_msgs/Vector3 angular_velocity
float64[9] angular_velocity_covariance
geometry_msgs/Vector3 linear_acceleration
float64[9] linear_acceleration_covariance
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
================================================================================
MSG: geometry_msgs/Quaternion
float64 x
float64 y
float64 z
float64 w
================================================================================
MSG: geometry_msgs/Vector3
float64 x
float64 y
float64 z
"""

# Rows 15 to 21 are missing.
row = np.array([i for i in range(COUNT + 7) if not 15 <= i < 22])
stamps = START_NS + STEP_NS * row
rates = np.random.default_rng(1).normal(0.01, 0.003, (COUNT, 3))
forces = np.random.default_rng(2).normal(0.0, 0.1, (COUNT, 3))
# Binary formats have floating-point times, in s from the start.
times = STEP_NS * row / 1e9


def write_text():
    names = ["time [ns]", *(f"g{axis} [rad/s]" for axis in "xyz"), *(f"a{axis} [m/s^2]" for axis in "xyz")]
    rows = (f"{t},{','.join(repr(float(x)) for x in (*g, *a))}" for t, g, a in zip(stamps, rates, forces))
    (FOLDER / "imu.csv").write_text("\n".join([",".join(names), *rows]) + "\n")


def write_arrays():
    np.save(FOLDER / "imu.npy", np.column_stack([times, rates]))
    np.savez(FOLDER / "imu.npz", time_s=times, gyro=rates)
    np.savez_compressed(FOLDER / "imu_packed.npz", time_s=times, gyro=rates)
    variables = {"time_s": times, "gyro": rates, "fs": 200.0, "about": "an IMU"}
    scipy.io.savemat(FOLDER / "imu.mat", {"imu": variables})
    scipy.io.savemat(FOLDER / "imu_packed.mat", variables, do_compression=True)
    np.column_stack([times, rates]).astype("<f8").tofile(FOLDER / "imu.bin")


def write_hdf5():
    with h5py.File(FOLDER / "imu.h5", "w") as file:
        file["imu/time"], file["imu/gyro"], file["fs"] = times, rates, 200.0
        file["imu/time"].attrs["units"], file["imu/gyro"].attrs["units"] = "s", "rad/s"
    with h5py.File(FOLDER / "imu_packed.h5", "w", libver="latest") as file:
        packed = {"compression": "gzip", "shuffle": True, "fletcher32": True}
        file.create_dataset("time_s", data=times, chunks=(16,), **packed)
        file.create_dataset("gyro", data=rates, chunks=(16, 2), **packed)
    # As MATLAB writes version 7.3: a block of text, and transposed matrices.
    with h5py.File(FOLDER / "imu_v73.mat", "w", userblock_size=512) as file:
        file.create_dataset("time_s", data=times[np.newaxis], chunks=(1, 16), compression="gzip")
        file.create_dataset("gyro", data=rates.T, chunks=(2, 16), compression="gzip")
    header = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + struct.pack("<H", 0x0200) + b"IM"
    with open(FOLDER / "imu_v73.mat", "r+b") as file:
        file.write(header)


def write_mcap(name, rows=slice(COUNT), **options):
    def vector(values):
        return dict(zip("xyz", map(float, values)))

    with open(FOLDER / name, "wb") as file:
        writer = Mcap(file, **options)
        schema = writer.register_msgdef("sensor_msgs/msg/Imu", IMU)
        for stamp, rate, force in zip(stamps[rows].tolist(), rates[rows], forces[rows]):
            time = {"sec": stamp // 10**9, "nanosec": stamp % 10**9}
            message = {
                "header": {"stamp": time, "frame_id": "imu"},
                "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0},
                "orientation_covariance": [-1.0] + [0.0] * 8,
                "angular_velocity": vector(rate),
                "angular_velocity_covariance": [0.0] * 9,
                "linear_acceleration": vector(force),
                "linear_acceleration_covariance": [0.0] * 9,
            }
            writer.write_message("/imu/data", schema, message, log_time=stamp, publish_time=stamp)
        writer.finish()


# Messages of PX4 as of version 1.16.
PX4 = {
    "SensorGyro": "uint64 timestamp\nuint64 timestamp_sample\nuint32 device_id\nfloat32 x\nfloat32 y\nfloat32 z\n"
    "float32 temperature\nuint32 error_count\nuint8[3] clip_counter\nuint8 samples\nuint8 ORB_QUEUE_LENGTH = 8\n",
    "SensorGyroFifo": "uint64 timestamp\nuint64 timestamp_sample\nuint32 device_id\nfloat32 dt\nfloat32 scale\n"
    "uint8 samples\nint16[32] x\nint16[32] y\nint16[32] z\nuint8 ORB_QUEUE_LENGTH = 4\n",
    "SensorCombined": "uint64 timestamp\nint32 RELATIVE_TIMESTAMP_INVALID = 2147483647\nfloat32[3] gyro_rad\n"
    "uint32 gyro_integral_dt\nint32 accelerometer_timestamp_relative\nfloat32[3] accelerometer_m_s2\n"
    "uint32 accelerometer_integral_dt\nuint8 CLIPPING_X = 1\nuint8 accelerometer_clipping\nuint8 gyro_clipping\n"
    "uint8 accel_calibration_count\nuint8 gyro_calibration_count\n",
    "VehicleImu": "uint64 timestamp\nuint64 timestamp_sample\nuint32 accel_device_id\nuint32 gyro_device_id\n"
    "float32[3] delta_angle\nfloat32[3] delta_velocity\nuint32 delta_angle_dt\nuint32 delta_velocity_dt\n"
    "uint8 CLIPPING_X = 1\nuint8 delta_angle_clipping\nuint8 delta_velocity_clipping\n"
    "uint8 accel_calibration_count\nuint8 gyro_calibration_count\n",
}


def px4_messages():
    """Type, time in ns and fields of the messages of an IMU of PX4; a batch has three samples, and its clock is that of `write_fifo`."""
    counts = np.round(rates / 1e-6).astype("<i2")
    for at, stamp in enumerate((10_000_000_000 + STEP_NS * row).tolist()):
        time = stamp // 1000
        head = {"timestamp": time + 500, "timestamp_sample": time}
        turn = dict(zip("xyz", (2 * rates[at]).tolist()))
        rest = {"temperature": 25.0, "error_count": 0, "clip_counter": np.zeros(3, "u1"), "samples": 1}
        yield "SensorGyro", stamp, {**head, "device_id": 7, **turn, **rest}
        vectors = {"gyro_rad": rates[at].astype("f4"), "gyro_integral_dt": 5000, "accelerometer_timestamp_relative": 0}
        vectors |= {"accelerometer_m_s2": forces[at].astype("f4"), "accelerometer_integral_dt": 5000}
        flags = {"accel_calibration_count": 1, "gyro_calibration_count": 1}
        clipping = {"accelerometer_clipping": 0, "gyro_clipping": 0}
        yield "SensorCombined", stamp, {"timestamp": time, **vectors, **clipping, **flags}
        increments = {"delta_angle": (rates[at] * 5e-3).astype("f4"), "delta_velocity": (forces[at] * 5e-3).astype("f4")}
        increments |= {"delta_angle_dt": 5000, "delta_velocity_dt": 5000, "delta_angle_clipping": 0, "delta_velocity_clipping": 0}
        yield "VehicleImu", stamp, {**head, "accel_device_id": 7, "gyro_device_id": 7, **increments, **flags}
        if at % 3 == 2:
            lists = np.zeros((3, 32), "<i2")
            lists[:, :3] = counts[at - 2 : at + 1].T
            batch = {"device_id": 7, "dt": 4950.0, "scale": 1e-6, "samples": 3, **dict(zip("xyz", lists))}
            yield "SensorGyroFifo", stamp, {**head, **batch}


def topic_of(kind):
    return "/fmu/out/" + "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in kind)[1:]


def write_px4_mcap():
    with open(FOLDER / "px4.mcap", "wb") as file:
        writer = Mcap(file)
        schemas = {kind: writer.register_msgdef(f"px4_msgs/msg/{kind}", text) for kind, text in PX4.items()}
        for kind, stamp, fields in px4_messages():
            fields = {name: x.tolist() if isinstance(x, np.ndarray) else x for name, x in fields.items()}
            writer.write_message(topic_of(kind), schemas[kind], fields, log_time=stamp, publish_time=stamp)
        writer.finish()


def write_px4_db3():
    """As ROS 2 Humble records messages of PX4, without their definitions."""
    store = get_typestore(Stores.ROS2_HUMBLE)
    for kind, text in PX4.items():
        store.register(get_types_from_msg(text, f"px4_msgs/msg/{kind}"))
    bag = new_db3("px4.db3", [(topic_of(kind), f"px4_msgs/msg/{kind}") for kind in PX4])
    for kind, stamp, fields in px4_messages():
        name = f"px4_msgs/msg/{kind}"
        message = bytes(store.serialize_cdr(store.types[name](**fields), name))
        bag.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", (list(PX4).index(kind) + 1, stamp, message))
    bag.commit()
    bag.close()


def write_bag_folder():
    """A recording of ROS 2 in two files, of which the metadata have the order."""
    folder = FOLDER / "imu_bag"
    folder.mkdir(exist_ok=True)
    write_mcap("imu_bag/imu_bag_0.mcap", slice(20))
    write_mcap("imu_bag/imu_bag_1.mcap", slice(20, COUNT))
    (folder / "metadata.yaml").write_text(
        "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: mcap\n  relative_file_paths:\n"
        f"    - imu_bag_0.mcap\n    - imu_bag_1.mcap\n  message_count: {COUNT}\n"
    )


def write_bag(name, packing=None):
    store = get_typestore(Stores.ROS1_NOETIC)
    types = store.types
    vector, covariance = types["geometry_msgs/msg/Vector3"], np.zeros(9)
    (FOLDER / name).unlink(missing_ok=True)
    bag = Bag(FOLDER / name)
    if packing:
        bag.set_compression(packing)
    if packing == Bag.CompressionFormat.LZ4:
        # With a checksum, as ROS writes it.
        bag.compressor = lambda chunk: lz4.frame.compress(chunk, content_checksum=True)
    with bag:
        connection = bag.add_connection("/imu/data", "sensor_msgs/msg/Imu", typestore=store)
        for at, (stamp, rate, force) in enumerate(zip(stamps.tolist(), rates, forces)):
            time = types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
            header = types["std_msgs/msg/Header"](at, time, "imu")
            quaternion = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
            parts = (quaternion, covariance, vector(*rate), covariance, vector(*force), covariance)
            message = types["sensor_msgs/msg/Imu"](header, *parts)
            bag.write(connection, stamp, store.serialize_ros1(message, "sensor_msgs/msg/Imu"))


def write_parquet():
    """Times of the calendar and a column with nulls in place of rates, in parts of 16 rows, with and without checksums."""
    table = {
        "time": pyarrow.array(stamps, pyarrow.timestamp("ns")),
        "note": pyarrow.array(["sound"] * COUNT),
        **{f"g{axis} [rad/s]": rates[:, at] for at, axis in enumerate("xyz")},
        "a [m/s^2]": pyarrow.array([None if i % 5 == 0 else float(force[0]) for i, force in enumerate(forces)]),
        "count": pyarrow.array(row, pyarrow.uint32()),
    }
    table = pyarrow.table(table)
    write = pyarrow.parquet.write_table
    write(table, FOLDER / "imu.parquet", row_group_size=16)
    options = {"compression": "zstd", "data_page_version": "2.0", "use_dictionary": False}
    write(table, FOLDER / "imu_packed.parquet", **options)
    packing = {name: "gzip" if name.startswith("a") else "lz4" for name in table.column_names}
    write(table, FOLDER / "imu_lz4.parquet", compression=packing, use_dictionary=False)
    write(table.select(["gx [rad/s]"]).slice(0, 3), FOLDER / "brotli.parquet", compression="brotli")


def ulog_message(kind, body):
    return struct.pack("<HB", len(body), ord(kind)) + body


def write_ulog():
    """Two gyros of PX4 with samples in single precision, and a dropout where rows are missing."""
    message = ulog_message
    fields = "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float x;float y;float z;"
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 9_000_000), message("B", bytes(40))]
    parts.append(message("I", bytes([14]) + b"char[3] sysPX4"))
    parts += [message("F", f"{topic}:{fields}".encode()) for topic in ("sensor_gyro", "sensor_accel")]
    topics = [(0, "sensor_gyro", rates), (1, "sensor_gyro", 2 * rates), (0, "sensor_accel", forces)]
    for number, (instance, topic, _) in enumerate(topics):
        parts.append(message("A", struct.pack("<BH", instance, number) + topic.encode()))
    for at, time in enumerate(10_000_000 + STEP_NS * row // 1000):
        if at == 15:
            parts.append(message("O", struct.pack("<H", 35)))
        for number, (_, _, values) in enumerate(topics):
            data = struct.pack("<HQQI3f", number, time + 500, time, 7, *values[at])
            parts.append(message("D", data))
    (FOLDER / "imu.ulg").write_bytes(b"".join(parts))


def write_fifo():
    """A gyro of PX4 in batches of three samples, whose time is that of the last, by a clock 1 % slower than the nominal one."""
    fields = "uint64_t timestamp;uint64_t timestamp_sample;uint32_t device_id;float dt;float scale;uint8_t samples;"
    fields += "".join(f"int16_t[32] {axis};" for axis in "xyz")
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 9_000_000), ulog_message("B", bytes(40))]
    parts.append(ulog_message("F", f"sensor_gyro_fifo:{fields}".encode()))
    parts.append(ulog_message("A", struct.pack("<BH", 0, 3) + b"sensor_gyro_fifo"))
    counts = np.round(rates / 1e-6).astype("<i2")
    for at in range(0, COUNT, 3):
        time = 10_000_000 + STEP_NS * int(row[at + 2]) // 1000
        lists = np.zeros((3, 32), "<i2")
        lists[:, :3] = counts[at : at + 3].T
        data = struct.pack("<HQQIffB", 3, time + 500, time, 7, 4950.0, 1e-6, 3) + lists.tobytes()
        parts.append(ulog_message("D", data))
    (FOLDER / "imu_fifo.ulg").write_bytes(b"".join(parts))


def dataflash_message(kind, body):
    return bytes([0xA3, 0x95, kind]) + body


def write_batches():
    """Two batches of a gyro of ArduPilot of 64 samples each at 200 Hz, the second behind the first."""
    kinds = [
        (128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns"),
        (30, 31, b"ISBH", b"QHBBHHQf", b"TimeUS,N,type,instance,mul,smp_cnt,SampleUS,smp_rate"),
        (31, 207, b"ISBD", b"QHHaaa", b"TimeUS,N,seqno,x,y,z"),
    ]
    parts = [dataflash_message(128, struct.pack("<BB4s16s64s", *kind)) for kind in kinds]
    values = np.random.default_rng(3).normal(0.01, 0.003, (128, 3))
    counts = np.round(values * 60_000).astype("<i2")
    for number in range(2):
        begun = 10_000_000 + 320_000 * number
        head = struct.pack("<QHBBHHQf", begun + 400_000, number, 1, 0, 60_000, 64, begun, 200.0)
        parts.append(dataflash_message(30, head))
        for part in range(2):
            lists = counts[64 * number + 32 * part :][:32].T
            body = struct.pack("<QHH", begun + 400_000, number, part) + np.ascontiguousarray(lists).tobytes()
            parts.append(dataflash_message(31, body))
    (FOLDER / "imu_batches.bin").write_bytes(b"".join(parts))


def write_dataflash():
    """Two gyros of ArduPilot as GYR, and the first with its accelerometer as IMU, at half the rate."""
    message = dataflash_message
    kinds = [
        (128, 89, b"FMT", b"BBnNZ", b"Type,Length,Name,Format,Columns"),
        (20, 32, b"GYR", b"QBQfff", b"TimeUS,I,SampleUS,GyrX,GyrY,GyrZ"),
        (21, 36, b"IMU", b"QBffffff", b"TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ"),
    ]
    parts = [message(128, struct.pack("<BB4s16s64s", *kind)) for kind in kinds]
    for at, time in enumerate(10_000_000 + STEP_NS * row // 1000):
        for instance in (0, 1):
            parts.append(message(20, struct.pack("<QBQ3f", time + 300, instance, time, *(1 + instance) * rates[at])))
        if at % 2 == 0:
            parts.append(message(21, struct.pack("<QB6f", time, 0, *rates[at], *forces[at])))
    (FOLDER / "imu_log.bin").write_bytes(b"".join(parts))


def new_db3(name, topics):
    """An empty bag of ROS 2 in SQLite."""
    path = FOLDER / name
    path.unlink(missing_ok=True)
    bag = sqlite3.connect(path)
    bag.execute("PRAGMA page_size = 512")
    bag.executescript("""
        CREATE TABLE schema(schema_version INTEGER PRIMARY KEY,ros_distro TEXT NOT NULL);
        CREATE TABLE topics(id INTEGER PRIMARY KEY,name TEXT NOT NULL,type TEXT NOT NULL,
            serialization_format TEXT NOT NULL,offered_qos_profiles TEXT NOT NULL);
        CREATE TABLE messages(id INTEGER PRIMARY KEY,topic_id INTEGER NOT NULL,timestamp INTEGER NOT NULL, data BLOB NOT NULL);
        CREATE INDEX timestamp_idx ON messages (timestamp ASC);
    """)
    bag.executemany("INSERT INTO topics(name, type, serialization_format, offered_qos_profiles) VALUES (?, ?, 'cdr', '')", topics)
    return bag


def write_db3():
    """A bag of ROS 2 in SQLite with pages of 512 bytes, so that there are several levels, and messages on pages of their own."""
    store = get_typestore(Stores.ROS2_IRON)
    types = store.types
    vector, covariance = types["geometry_msgs/msg/Vector3"], np.zeros(9)
    topics = [("/imu/data", "sensor_msgs/msg/Imu"), ("/chatter", "std_msgs/msg/String"), ("/twist", "geometry_msgs/msg/TwistStamped")]
    bag = new_db3("imu.db3", topics)
    for stamp, rate, force in zip(stamps.tolist(), rates, forces):
        time = types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
        header = types["std_msgs/msg/Header"](time, "imu")
        quaternion = types["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.0, 1.0)
        parts = (quaternion, covariance, vector(*rate), covariance, vector(*force), covariance)
        twist = types["geometry_msgs/msg/Twist"](vector(*force), vector(*(2 * rate)))
        messages = [
            types["sensor_msgs/msg/Imu"](header, *parts),
            types["std_msgs/msg/String"]("x" * 100),
            types["geometry_msgs/msg/TwistStamped"](header, twist),
        ]
        for number, (message, (_, kind)) in enumerate(zip(messages, topics), 1):
            data = bytes(store.serialize_cdr(message, kind))
            bag.execute("INSERT INTO messages(topic_id, timestamp, data) VALUES (?, ?, ?)", (number, stamp, data))
    bag.commit()
    bag.close()


def write_zstd():
    """A table in two frames with checksums, between them one that is to be skipped."""
    text = "time [ms],gz [dps]\n" + "".join(f"{i},{i % 7}\n" for i in range(50))
    frame = zstandard.ZstdCompressor(write_checksum=True).compress
    parts = [frame(text.encode()[:100]), struct.pack("<II", 0x184D2A50, 5), b"hello", frame(text.encode()[100:])]
    (FOLDER / "table.csv.zst").write_bytes(b"".join(parts))


write_text()
write_arrays()
write_hdf5()
write_mcap("imu.mcap")
write_px4_mcap()
write_px4_db3()
write_bag_folder()
write_bag("imu.bag")
write_bag("imu_packed.bag", Bag.CompressionFormat.LZ4)
write_bag("imu_bz2.bag", Bag.CompressionFormat.BZ2)
write_parquet()
write_ulog()
write_fifo()
write_dataflash()
write_batches()
write_db3()
(FOLDER / "imu.csv.gz").write_bytes(gzip.compress((FOLDER / "imu.csv").read_bytes(), mtime=0))
write_zstd()
