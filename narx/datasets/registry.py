"""Public recordings: address, licence, and SHA-256 of every file that can be downloaded."""

# a SHA-256 and its path do not fit into a line
# ruff: noqa: E501

from typing import NamedTuple


class PublicRecordings(NamedTuple):
    """Where a source is published, at a fixed commit.

    Parameters
    ----------
    url : str
        Address that file names are appended to.
    licence : str
        The recordings' own licence.
    sha256 : dict of str to str
        Path below the address to 64 hexadecimal digits.
    """

    url: str
    licence: str
    sha256: dict[str, str]


PUBLIC: dict[str, PublicRecordings] = {
    "smartphone_pocket": PublicRecordings(
        "https://raw.githubusercontent.com/"
        "tyrex-team/benchmarks-attitude-smartphones/8ad1100294465251560723c3bfa4e823e9feed52/datasets/",
        "CeCILL 2.1",
        {
            "android/Guillaume_Nexus5_NoDist_FrontPocket/accelerometer.txt": "14a7ed9f5e7ddafc1bf0d666917639a9d0582bf4aab348da1f5499555513fb14",
            "android/Guillaume_Nexus5_NoDist_FrontPocket/gyroscope.txt": "dbd410f76bed272b0878ca2c7ce6578a30a8f1a16c8d6195899840f3bcf0c20b",
            "android/Guillaume_Nexus5_NoDist_FrontPocket/timeAlignment.txt": "5313b2fe6315af5a72bae564f3abd866213c9d19ee8f3cacf71116d1fca8e9c1",
            "android/Thibaud_Nexus5_NoDist_FrontPocket/accelerometer.txt": "5a3c04c8863d73814fbf5001eaa7d9a82f6cb8607189f2a58603b8957e5187ff",
            "android/Thibaud_Nexus5_NoDist_FrontPocket/gyroscope.txt": "eca26b84a9ac8a976ed4373aeb7bc8e64c6ee64f167bff294a8c7d04676caa75",
            "android/Thibaud_Nexus5_NoDist_FrontPocket/timeAlignment.txt": "63b0766819128c37e135b9cc0dca1ad93c5a805efa465faf22c2c7bb15b407fb",
            "android/calib_gyr_Nexus5_d3/accelerometer.txt": "fbff1017ff2c2987397e6523ed0f27a2e476a6d39907613e97869bf01e77931a",
            "android/calib_gyr_Nexus5_d3/gyroscope.txt": "561230234c16dd2473c3316e61227519c38f721131b8954bdb275b850f92c792",
            "ios/Guillaume_iPhone4S_NoDist_FrontPocket/accelerometer.txt": "8d59d3dfc71bfc73a4393c1c0520e2f3c622ace63e054362ede25e9b88ef461c",
            "ios/Guillaume_iPhone4S_NoDist_FrontPocket/description.txt": "760d6b6b8922cabd3cbc82294d4124b36f7e903144ad381df3fbc769b9436a3f",
            "ios/Guillaume_iPhone4S_NoDist_FrontPocket/gyroscope.txt": "752150c6314d7183b4fde18b1a8bf54eb248f1ee4403d7c49165c5ea1315dcf7",
            "ios/Guillaume_iPhone4S_NoDist_FrontPocket/timeAlignment.txt": "1ff2f67b212c3a7468773752ca79e26c88c6ff6e109cbd5802b764e4a9ed6ac6",
            "ios/Guillaume_iPhone5_NoDist_FrontPocket/accelerometer.txt": "ecabc8f9b814971c406d13333ac13c0aa1a6e505d66da44557d033f3002ace42",
            "ios/Guillaume_iPhone5_NoDist_FrontPocket/description.txt": "d655ba5e01a5903437b6df716e4e6eea8b6c55203fbcda25fdabb8de3bf22fa7",
            "ios/Guillaume_iPhone5_NoDist_FrontPocket/gyroscope.txt": "ee8d9637d4c509be0fb41f328b6b4ebfab4cca6f0d9fe4d6cb6e692899a1e7cf",
            "ios/Guillaume_iPhone5_NoDist_FrontPocket/timeAlignment.txt": "315d8c8ec997bb94227a83ef3b61c5693420fb6a6f99c187b9eb9c88e5c6b243",
            "ios/Thibaud_iPhone4S_NoDist_FrontPocket/accelerometer.txt": "a7bf220f48a72095482799a65a748d76cc0c621120ea6d5536f7c868c5c74c0c",
            "ios/Thibaud_iPhone4S_NoDist_FrontPocket/description.txt": "c082e5c641816a01938a44f8fb7b201507f1ba052e6e3cb36230280e1cab21b0",
            "ios/Thibaud_iPhone4S_NoDist_FrontPocket/gyroscope.txt": "29ad12c8a30b17816ba24b33518930fe005cdf919a58a369bc01f68f0681e6cf",
            "ios/Thibaud_iPhone4S_NoDist_FrontPocket/timeAlignment.txt": "41ac66e2dc0d4ead7a65f0435fc50bca9f8bc267f7e5a28c48244b9fe15d7deb",
            "ios/Thibaud_iPhone5_NoDist_FrontPocket/accelerometer.txt": "8f5ed7eb0387cfdc9a9540d71611f0adfba1cc6cb34f5e904e21d6bde94b8271",
            "ios/Thibaud_iPhone5_NoDist_FrontPocket/description.txt": "a14c1f6a4edd03166d767aaa516b5ed97367e6e9c73dfb4ba1a8af40ec13f018",
            "ios/Thibaud_iPhone5_NoDist_FrontPocket/gyroscope.txt": "694dd5e76b904c8973a76114014116c2ebb0b70598bfecc6477fd4c24ef1df53",
            "ios/Thibaud_iPhone5_NoDist_FrontPocket/timeAlignment.txt": "a08a5dc8aba1e01acfbe4eca21820d3fe2c0d7ae0fe16e81a21245c551c308aa",
            "ios/calib_gyr_iPhone4S_d3/accelerometer.txt": "fbadd92cb04c6ae39fe729eeb3c9b22eca24f881fab42db49d0cdb560c66f90f",
            "ios/calib_gyr_iPhone4S_d3/description.txt": "a7c534a70283b3a42f5b9ccc6cefc009f1ebb8fdff01e3c637fa1b22f280a133",
            "ios/calib_gyr_iPhone4S_d3/gyroscope.txt": "5109ef9cb9ad19031c1b0305e875369165ec6983af9550381a645aafe40af9c4",
            "ios/calib_gyr_iPhone5_d3/accelerometer.txt": "6ead65e0c09789c76f56f14a5cf5b9781d484ce3c8ef3381a83a4f7fab3a5bc3",
            "ios/calib_gyr_iPhone5_d3/description.txt": "d127dc9a5fd3b68308c4041d7a4a8467c2b431a5392593752cab69060b4ceb3b",
            "ios/calib_gyr_iPhone5_d3/gyroscope.txt": "ddeed57da1449819e55a05e953020cb642e9e12e9e765fe2b4e1fc6e6da69cda",
            "qualisys/Guillaume_Nexus5_NoDist_FrontPocket.mat": "e24396ad7817d8041fbfe42ec57b2e69d6272011ceef67b5602f4942d0abb2f6",
            "qualisys/Guillaume_iPhone4S_NoDist_FrontPocket.mat": "c583e604ace2af05f6175b8134f99b35b484425de3d897920386f35a8caf9fd7",
            "qualisys/Guillaume_iPhone5_NoDist_FrontPocket.mat": "a9dd3077c2208d6ec1f367fbc7706948507a866bd68f5a4376c45cf121fe0704",
            "qualisys/Thibaud_Nexus5_NoDist_FrontPocket.mat": "9187adfeb05855dc7772c4cb103d7a5d9c0c115dc57da3ef2ab77f80ac53af6e",
            "qualisys/Thibaud_iPhone4S_NoDist_FrontPocket.mat": "efaccc02c8bb40b7723148eeee4b8638ba84f18181339bedef3256c1ff0944f6",
            "qualisys/Thibaud_iPhone5_NoDist_FrontPocket.mat": "e83169d5aa5ea183e1d3811dc4c957ac8357424b4d2f590a6d9cdffee6dab505",
        },
    ),
    "neura_sample": PublicRecordings(
        "https://raw.githubusercontent.com/"
        "gait-tech/gaittoolbox/5f22592759da133223049b55e348859a4f55fa9d/data/sample/",
        "GPL-3.0",
        {
            "rawimu/S02-Trial-Walk-1-000_00B40BA5.txt": "1939fa3b9cb7e3780037b6486d2becc5ad7dcbf3f77d8860ffd4362d50c37334",
            "rawimu/S02-Trial-Walk-1-000_00B40C35.txt": "65df0447162b50633ad22416686ff6271afd472a88957f423737e341ebedbe74",
            "rawimu/S02-Trial-Walk-1-000_00B40C3C.txt": "050eeb7035d8937ac882ba1929dcf351c188b4f5496d5a19c2e447fca93df75f",
            "rawimu/S02-Trial-Walk-1-000_00B40C45.txt": "099887a9ab093aee8b0b7439025fe30480e02aa9124b183c81c04098af82a395",
            "rawvicon/S02-Trial-Walk-1.mat": "3ab10cbe92dc20f3f722197ed6d1e6fbd6c144e614988b312c7d7765d6aadabf",
        },
    ),
    "joint_1to3dof": PublicRecordings(
        "https://raw.githubusercontent.com/"
        "daniel-om-weber/dfjimu/a4815382e00d9dcc902ab55fcd793a7f85314e7d/data/",
        "MIT",
        {
            "data_1D_01.mat": "a1e3478954c8ca6e90cded32ae6ddb4205006c065b34171aa461ff6fca5c78af",
            "data_1D_02.mat": "754ff144b5e0ce926edf62dfde339d13c4706ec0180403e8f90863443ae450f2",
            "data_1D_04.mat": "348f5b8d90b83f9113b63796d45d1ca79145b0b83382c4b69bd7202b07d6f987",
            "data_1D_05.mat": "381c9337440888c68e340fb0b0018015e5c4c66fbd9b981041cb53855f175895",
            "data_2D_01.mat": "eea484773798cf1d392d5bedb102687c811d5a35fabd956e673772e8c16713a8",
            "data_2D_02.mat": "177314a4058a80deaa462e529f728c25d3d58538902ce696d1cb4833eeb0a9c7",
            "data_2D_03.mat": "b75543d4f15580220252585fee8fa564f940c18e1caa38f2887ca6202571bbc1",
            "data_2D_05.mat": "bd0312c0ac47f7d7a7252bc9677ca677e4974faa3a6f31bf8bab7f9bc0799923",
            "data_3D_01.mat": "d49415e6e637db69a937e58020e4f053abeb5124cf140cf6d08eff51a3e3419e",
            "data_3D_02.mat": "45a31d5d642d15909b23ba20c7f596b0db4dcb000f6e0deb6b7354cc99f02d7b",
            "data_3D_03.mat": "5ad0eacbd34de14430e33eac145562c02a866edae14155407078de9a6aaa9ea7",
            "data_3D_04.mat": "da66b540a83ab0808bebd462675fdbc3b4b71d6cffbdc0b8fad7dc0fe6e931b2",
        },
    ),
    "broad": PublicRecordings(
        "https://raw.githubusercontent.com/"
        "dlaidig/broad/7e2f8189bb4a3ac91eae32c69b6bc87f08a6e2ad/data_mat/",
        "CC-BY-4.0",
        {
            "01_undisturbed_slow_rotation_A.mat": "ad2cec0390a279953084e1de12dfd8d542af55e4ea187e68e8ebb7c316ecb96b",
            "06_undisturbed_fast_rotation_A.mat": "61cb32774b40c33d16a172dbe06503b4a3cb0b2d3e9b8eae0df66c313506a8e2",
            "08_undisturbed_fast_rotation_with_breaks_A.mat": "18f754d90fc4442dd9b01e116bf2b763d71517098702d77096080657a9460fd3",
            "10_undisturbed_slow_translation_A.mat": "eee6293f1d0aaf8d0ac025b873667f6f7697acad318057f4fd6a801fb31c93c1",
            "15_undisturbed_fast_translation_A.mat": "4290740d09dc3e055dd3cc939d083fa55321a9c90c0cb0aa3a6ffc26c4350951",
            "18_undisturbed_fast_translation_with_breaks_B.mat": "7ed161c035cbb48fe9431a51cabb5b2dcab84255fd417b7222159ff72cdeb60d",
            "21_undisturbed_fast_combined.mat": "cb7be66ffc50d7d2b23abaf72a85a76925ea2db36a3fd575998811fcf68c219a",
        },
    ),
}
