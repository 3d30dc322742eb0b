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
            "android/Guillaume_Nexus5_NoDist_BackPocket/accelerometer.txt": "5fbcfb3dd792a6728d57636c3f292e5dfcb7eaf2ff76b8ec7b1787cab437a588",
            "android/Guillaume_Nexus5_NoDist_BackPocket/gyroscope.txt": "8101d5964875ce5018ba213e194610a8429e81ddb1a81ea922a4c20bf03c553d",
            "android/Guillaume_Nexus5_NoDist_BackPocket/timeAlignment.txt": "315d8c8ec997bb94227a83ef3b61c5693420fb6a6f99c187b9eb9c88e5c6b243",
            "android/Guillaume_Nexus5_NoDist_FrontPocket/accelerometer.txt": "14a7ed9f5e7ddafc1bf0d666917639a9d0582bf4aab348da1f5499555513fb14",
            "android/Guillaume_Nexus5_NoDist_FrontPocket/gyroscope.txt": "dbd410f76bed272b0878ca2c7ce6578a30a8f1a16c8d6195899840f3bcf0c20b",
            "android/Guillaume_Nexus5_NoDist_FrontPocket/timeAlignment.txt": "5313b2fe6315af5a72bae564f3abd866213c9d19ee8f3cacf71116d1fca8e9c1",
            "android/Thibaud_Nexus5_NoDist_BackPocket/accelerometer.txt": "c6d9ef4bb426a938267e98e856ad60c63bc971ba975857b8f8ede5d79aed805c",
            "android/Thibaud_Nexus5_NoDist_BackPocket/gyroscope.txt": "5729ac67c68e5b628d8a0d72e5a96063467129fdd979790d6b4c424990377278",
            "android/Thibaud_Nexus5_NoDist_BackPocket/timeAlignment.txt": "207bf80ea23d2c4fa7c9369ac021c16cd0df6f7d306b6a08e4765e34a43cf5db",
            "android/Thibaud_Nexus5_NoDist_FrontPocket/accelerometer.txt": "5a3c04c8863d73814fbf5001eaa7d9a82f6cb8607189f2a58603b8957e5187ff",
            "android/Thibaud_Nexus5_NoDist_FrontPocket/gyroscope.txt": "eca26b84a9ac8a976ed4373aeb7bc8e64c6ee64f167bff294a8c7d04676caa75",
            "android/Thibaud_Nexus5_NoDist_FrontPocket/timeAlignment.txt": "63b0766819128c37e135b9cc0dca1ad93c5a805efa465faf22c2c7bb15b407fb",
            "android/calib_gyr_Nexus5_d3/accelerometer.txt": "fbff1017ff2c2987397e6523ed0f27a2e476a6d39907613e97869bf01e77931a",
            "android/calib_gyr_Nexus5_d3/gyroscope.txt": "561230234c16dd2473c3316e61227519c38f721131b8954bdb275b850f92c792",
            "ios/Guillaume_iPhone4S_Dist_FrontPocket/accelerometer.txt": "dcc20e599e068240f62752630e66f88df026801e80ef7e38289baf15e6b9a306",
            "ios/Guillaume_iPhone4S_Dist_FrontPocket/description.txt": "1ee3dede38fcd3c2a64bffe995cde4dff1b46054f5767f2ecc839915388ade37",
            "ios/Guillaume_iPhone4S_Dist_FrontPocket/gyroscope.txt": "475c821458ef89ab7fbabaa854959e690c7ec18eb6d476c9cf6cca9a3d9053f0",
            "ios/Guillaume_iPhone4S_Dist_FrontPocket/timeAlignment.txt": "fd9ed3f0aaacaa3005e4ba0ef863a318e5e63edbb79516e5b201b13d37a025d2",
            "ios/Guillaume_iPhone4S_NoDist_BackPocket/accelerometer.txt": "c06c8a4dd8aac79bdc2df333c82e3f9fa4547df6553e4c0009806cc8799cc964",
            "ios/Guillaume_iPhone4S_NoDist_BackPocket/description.txt": "ed844980f850442bdad8558feca50a92859e196cb95f76dc8cb0880eca873a5e",
            "ios/Guillaume_iPhone4S_NoDist_BackPocket/gyroscope.txt": "1f8cb14bf176097305364729cad2046b069d7d00f27559d9fd6e88cd03d37a21",
            "ios/Guillaume_iPhone4S_NoDist_BackPocket/timeAlignment.txt": "5f8c9a8388dbad043b4e4f1c8da6f0c10a7d9c009f81568a257ae09f0e105498",
            "ios/Guillaume_iPhone4S_NoDist_FrontPocket/accelerometer.txt": "8d59d3dfc71bfc73a4393c1c0520e2f3c622ace63e054362ede25e9b88ef461c",
            "ios/Guillaume_iPhone4S_NoDist_FrontPocket/description.txt": "760d6b6b8922cabd3cbc82294d4124b36f7e903144ad381df3fbc769b9436a3f",
            "ios/Guillaume_iPhone4S_NoDist_FrontPocket/gyroscope.txt": "752150c6314d7183b4fde18b1a8bf54eb248f1ee4403d7c49165c5ea1315dcf7",
            "ios/Guillaume_iPhone4S_NoDist_FrontPocket/timeAlignment.txt": "1ff2f67b212c3a7468773752ca79e26c88c6ff6e109cbd5802b764e4a9ed6ac6",
            "ios/Guillaume_iPhone4S_NoDist_Phoning/accelerometer.txt": "5d89c6c47f2a105de6eccf5fda4aa1dcb2a140583922f75cfef042271e832e43",
            "ios/Guillaume_iPhone4S_NoDist_Phoning/description.txt": "490d7a6ec4bdef160a0dfc81366d92a83ec88da86391f94b93d17fa10963830f",
            "ios/Guillaume_iPhone4S_NoDist_Phoning/gyroscope.txt": "9a2a02deaadcfe0ed2c4e8031e888e82463ea106b5d03245ba352b8fef836ae5",
            "ios/Guillaume_iPhone4S_NoDist_Phoning/timeAlignment.txt": "92a600dba8df1b9f78f75bcc34a2be5c8a86c569eb505ab41d2e303f9c26e8fe",
            "ios/Guillaume_iPhone5_Dist_FrontPocket/accelerometer.txt": "90947756325a7535eb18b833b329822974910143538d79640463e2dbcac9c763",
            "ios/Guillaume_iPhone5_Dist_FrontPocket/description.txt": "0ca5b629527d03cfab132128920315f0dab5c94090e126df4f5769ef463e3640",
            "ios/Guillaume_iPhone5_Dist_FrontPocket/gyroscope.txt": "a4b46d88f93945d35913c7b20454af5f9db67f9c53ff228e3385404a4f586040",
            "ios/Guillaume_iPhone5_Dist_FrontPocket/timeAlignment.txt": "cf71a4ec84eae8270395aeeec0b104358537be8df2b45df31984bffec51b2c3b",
            "ios/Guillaume_iPhone5_NoDist_BackPocket/accelerometer.txt": "55698f917162acfd525cfc5869c0086bb314cf1c149244fd04f2119761d577d0",
            "ios/Guillaume_iPhone5_NoDist_BackPocket/description.txt": "f849d6f9be991ac0cd18587abed63dc8c20e76d014726a2e27c85b60612375a0",
            "ios/Guillaume_iPhone5_NoDist_BackPocket/gyroscope.txt": "ab7081856a2343d14fc672aad821f7d0490dcb30441870e15f5f090e7bfaad97",
            "ios/Guillaume_iPhone5_NoDist_BackPocket/timeAlignment.txt": "8ba449ba30e1167629d926d4509e7dbcf0a25b5a8d27b4115cf0333137c8b5bf",
            "ios/Guillaume_iPhone5_NoDist_FrontPocket/accelerometer.txt": "ecabc8f9b814971c406d13333ac13c0aa1a6e505d66da44557d033f3002ace42",
            "ios/Guillaume_iPhone5_NoDist_FrontPocket/description.txt": "d655ba5e01a5903437b6df716e4e6eea8b6c55203fbcda25fdabb8de3bf22fa7",
            "ios/Guillaume_iPhone5_NoDist_FrontPocket/gyroscope.txt": "ee8d9637d4c509be0fb41f328b6b4ebfab4cca6f0d9fe4d6cb6e692899a1e7cf",
            "ios/Guillaume_iPhone5_NoDist_FrontPocket/timeAlignment.txt": "315d8c8ec997bb94227a83ef3b61c5693420fb6a6f99c187b9eb9c88e5c6b243",
            "ios/Guillaume_iPhone5_NoDist_Swinging/accelerometer.txt": "3e3d96236745a3a278da8ae08125aefd8b05cdf82ccffd35cd7cea74e09b6630",
            "ios/Guillaume_iPhone5_NoDist_Swinging/description.txt": "abc9566e29383758e2987aaa82edf2e36427dcfa8a4b46c8417bc4002e786fba",
            "ios/Guillaume_iPhone5_NoDist_Swinging/gyroscope.txt": "63f249a3c1c0416dc4405f523efc40941e9424a328ee15a751ac82b078000ca6",
            "ios/Guillaume_iPhone5_NoDist_Swinging/timeAlignment.txt": "ba57153fb2ce0385b3776e4e8851dc3ce5f403310c3f26ff23d7e1cec0168780",
            "ios/Guillaume_iPhone5_NoDist_Texting/accelerometer.txt": "8a45e13b18cd54e20b6a145c96cb1a33d21493d41118b5a812104c19033d8e62",
            "ios/Guillaume_iPhone5_NoDist_Texting/description.txt": "1059e18aa6357cc86e8ab6758f98217aef8935b72682fc17d9998d879b81b9f7",
            "ios/Guillaume_iPhone5_NoDist_Texting/gyroscope.txt": "8ae3942e31209028eb408e35738ad8fd204509fcd72b9593fa6cadfa8a37584e",
            "ios/Guillaume_iPhone5_NoDist_Texting/timeAlignment.txt": "18e25c25e5ee485f12d5bf7730100c301c9be39b5f350a6410114e5761c993d1",
            "ios/Thibaud_iPhone4S_Dist_FrontPocket/accelerometer.txt": "5ca4cbc7d5d73e10b3f1c1e61873e03def85f7af32c732942d2318f4ab993cd8",
            "ios/Thibaud_iPhone4S_Dist_FrontPocket/description.txt": "dc22721e80338d3fcf08661edd896d3b97a14524c0d9b0dc407f0a3a2083b574",
            "ios/Thibaud_iPhone4S_Dist_FrontPocket/gyroscope.txt": "d559005edd61ec58beca8a25ccfa70dc5657fc6e797590908f7bf58b4a2d5637",
            "ios/Thibaud_iPhone4S_Dist_FrontPocket/timeAlignment.txt": "1d939c4b3b30bdb5a9b8916119d9b4bf7b832b1350f4fe09d6c3dde4b4768cc5",
            "ios/Thibaud_iPhone4S_NoDist_BackPocket/accelerometer.txt": "ea4843c739b7abfc0cb115f18d78fa74bb5ad687784d7de2e82039fa7094ae83",
            "ios/Thibaud_iPhone4S_NoDist_BackPocket/description.txt": "65fa276e4d188c1f203b91c9283f182347c3f987c27ea4ad96885b4a45d61c06",
            "ios/Thibaud_iPhone4S_NoDist_BackPocket/gyroscope.txt": "67198646e50adea1b9a5483bb2e265e7c74098afbb7f86cba2932d44c9f14b23",
            "ios/Thibaud_iPhone4S_NoDist_BackPocket/timeAlignment.txt": "4ac083f0e1f15ed97b502ea2fec33ca336dbb462a874f7a4200df312d9762fcb",
            "ios/Thibaud_iPhone4S_NoDist_FrontPocket/accelerometer.txt": "a7bf220f48a72095482799a65a748d76cc0c621120ea6d5536f7c868c5c74c0c",
            "ios/Thibaud_iPhone4S_NoDist_FrontPocket/description.txt": "c082e5c641816a01938a44f8fb7b201507f1ba052e6e3cb36230280e1cab21b0",
            "ios/Thibaud_iPhone4S_NoDist_FrontPocket/gyroscope.txt": "29ad12c8a30b17816ba24b33518930fe005cdf919a58a369bc01f68f0681e6cf",
            "ios/Thibaud_iPhone4S_NoDist_FrontPocket/timeAlignment.txt": "41ac66e2dc0d4ead7a65f0435fc50bca9f8bc267f7e5a28c48244b9fe15d7deb",
            "ios/Thibaud_iPhone4S_NoDist_Phoning/accelerometer.txt": "0a1a1c6bac6a3c2684b264a363cb6459b39788e434f3e14ec106612347342572",
            "ios/Thibaud_iPhone4S_NoDist_Phoning/description.txt": "91b4dd6f85b02e0b2ac284d46b1bcafc219a66a67ba2d008e834ebc4263e78e9",
            "ios/Thibaud_iPhone4S_NoDist_Phoning/gyroscope.txt": "3a7e3e2b44ac19446bca88697beabbd4ba941fe1ac995d9c754e9d4607252e87",
            "ios/Thibaud_iPhone4S_NoDist_Phoning/timeAlignment.txt": "173b31bff25a5fb930bb15852680b42a7c0279a1f610ef93c89a1c795d53e19d",
            "ios/Thibaud_iPhone5_Dist_FrontPocket/accelerometer.txt": "f76a959b8c97c2c2372045b67b0d2dfc7d978d14566262b8eec2cc39448f0b7f",
            "ios/Thibaud_iPhone5_Dist_FrontPocket/description.txt": "d9ee3388999eb242b35ffd44a120b8b6e83aed67a5eb59c062cb7892613c3702",
            "ios/Thibaud_iPhone5_Dist_FrontPocket/gyroscope.txt": "4655cf8d582909985f036afcf7f2dccab38bed226f8cd6619868df16c77825d6",
            "ios/Thibaud_iPhone5_Dist_FrontPocket/timeAlignment.txt": "a56fe135569d1936821db4311a83aed7ae26ba36652099e632ed57bc0fed44de",
            "ios/Thibaud_iPhone5_NoDist_BackPocket/accelerometer.txt": "18deb7bd3964a02e81b5aaf8716e00723ac9ca42e04820062cdbc172f6778ece",
            "ios/Thibaud_iPhone5_NoDist_BackPocket/description.txt": "73618860ef97b6529aaba191b29b9b49f2d1dbd1eec776d264834e0639795b5d",
            "ios/Thibaud_iPhone5_NoDist_BackPocket/gyroscope.txt": "4e039b01f709b4b5d7c87c110bc1a82dd42c7fc467733d1226f1e81f892409d1",
            "ios/Thibaud_iPhone5_NoDist_BackPocket/timeAlignment.txt": "6add48f27109d464ddfbb170655e94d297560187ade379f32228269c7d982f12",
            "ios/Thibaud_iPhone5_NoDist_FrontPocket/accelerometer.txt": "8f5ed7eb0387cfdc9a9540d71611f0adfba1cc6cb34f5e904e21d6bde94b8271",
            "ios/Thibaud_iPhone5_NoDist_FrontPocket/description.txt": "a14c1f6a4edd03166d767aaa516b5ed97367e6e9c73dfb4ba1a8af40ec13f018",
            "ios/Thibaud_iPhone5_NoDist_FrontPocket/gyroscope.txt": "694dd5e76b904c8973a76114014116c2ebb0b70598bfecc6477fd4c24ef1df53",
            "ios/Thibaud_iPhone5_NoDist_FrontPocket/timeAlignment.txt": "a08a5dc8aba1e01acfbe4eca21820d3fe2c0d7ae0fe16e81a21245c551c308aa",
            "ios/Thibaud_iPhone5_NoDist_Swinging/accelerometer.txt": "745e57723d528289067e7feba37947bc0bb3dbf706e27a82a78606400f4d7b20",
            "ios/Thibaud_iPhone5_NoDist_Swinging/description.txt": "2e78295a41a3809078f96404d28bacec0d9beba495368e4055bf3d71f31f9e93",
            "ios/Thibaud_iPhone5_NoDist_Swinging/gyroscope.txt": "e7f53c2c3792e17ba636b3257291b8a987fecee5c639ed592381c622bd93d0c2",
            "ios/Thibaud_iPhone5_NoDist_Swinging/timeAlignment.txt": "9a14bb2c6941111e98888dc8b0919da628c053ecbce55a5f5db2b273cb253c9f",
            "ios/Thibaud_iPhone5_NoDist_Texting/accelerometer.txt": "f426a84b5ee75ba5a1f65c0bcbeeaef61a6c942253eb33dcb2acb2d574c80e7d",
            "ios/Thibaud_iPhone5_NoDist_Texting/description.txt": "1ab481850040b3c95daa78015fc9b45e898a7fa0c3c21a8a5c2361339f5d4bde",
            "ios/Thibaud_iPhone5_NoDist_Texting/gyroscope.txt": "3a862f2183a08d36df4dcbd8c9eb8aa4c92b9ede32feffbd087502ef8511feb5",
            "ios/Thibaud_iPhone5_NoDist_Texting/timeAlignment.txt": "666232b055ba63a83d3c42ea3ffca9681b47eb7b519de36c40be0ab7c9073eb6",
            "ios/calib_gyr_iPhone4S_d3/accelerometer.txt": "fbadd92cb04c6ae39fe729eeb3c9b22eca24f881fab42db49d0cdb560c66f90f",
            "ios/calib_gyr_iPhone4S_d3/description.txt": "a7c534a70283b3a42f5b9ccc6cefc009f1ebb8fdff01e3c637fa1b22f280a133",
            "ios/calib_gyr_iPhone4S_d3/gyroscope.txt": "5109ef9cb9ad19031c1b0305e875369165ec6983af9550381a645aafe40af9c4",
            "ios/calib_gyr_iPhone5_d3/accelerometer.txt": "6ead65e0c09789c76f56f14a5cf5b9781d484ce3c8ef3381a83a4f7fab3a5bc3",
            "ios/calib_gyr_iPhone5_d3/description.txt": "d127dc9a5fd3b68308c4041d7a4a8467c2b431a5392593752cab69060b4ceb3b",
            "ios/calib_gyr_iPhone5_d3/gyroscope.txt": "ddeed57da1449819e55a05e953020cb642e9e12e9e765fe2b4e1fc6e6da69cda",
            "qualisys/Guillaume_Nexus5_NoDist_BackPocket.mat": "ad5e6b4f5598f07ee2a30af9ba4b01f7a81af568c35f2f81587f410fbf470715",
            "qualisys/Guillaume_Nexus5_NoDist_FrontPocket.mat": "e24396ad7817d8041fbfe42ec57b2e69d6272011ceef67b5602f4942d0abb2f6",
            "qualisys/Guillaume_iPhone4S_Dist_FrontPocket.mat": "9e96303a24009796d812540ed2a522a79cd554bc733aa7e2e0cb57e456e9ab7b",
            "qualisys/Guillaume_iPhone4S_NoDist_BackPocket.mat": "92850f3337a15437bd3c435e8f7e1af38590a0abbb38a342050987cc45b310ab",
            "qualisys/Guillaume_iPhone4S_NoDist_FrontPocket.mat": "c583e604ace2af05f6175b8134f99b35b484425de3d897920386f35a8caf9fd7",
            "qualisys/Guillaume_iPhone4S_NoDist_Phoning.mat": "7b9640ee3218c5efd54fd0a1eb7f625edb7b0f37d7a9ac9105e1757213b7455e",
            "qualisys/Guillaume_iPhone5_Dist_FrontPocket.mat": "7f03088eecf3706166dfe850eecbbddf2e2705bc84eba72690248635ce2ef7c3",
            "qualisys/Guillaume_iPhone5_NoDist_BackPocket.mat": "4a97e1ad8665846c3c68db1580d30341d8917c3c928de565aadb665e1a4d0127",
            "qualisys/Guillaume_iPhone5_NoDist_FrontPocket.mat": "a9dd3077c2208d6ec1f367fbc7706948507a866bd68f5a4376c45cf121fe0704",
            "qualisys/Guillaume_iPhone5_NoDist_Swinging.mat": "d07d5e26bee48c6e6e2f029b1958350c40366b0705241a9a10030f2397df48c2",
            "qualisys/Guillaume_iPhone5_NoDist_Texting.mat": "3c2df0c85ece7b248d4cf12e6034f2ab8fdfd52d067bed9842d2a254d49dcb29",
            "qualisys/Thibaud_Nexus5_NoDist_BackPocket.mat": "d3f45c17370c7fa6057a395f33a3bfc34ed0d7d19030af90729736ccac9f55ea",
            "qualisys/Thibaud_Nexus5_NoDist_FrontPocket.mat": "9187adfeb05855dc7772c4cb103d7a5d9c0c115dc57da3ef2ab77f80ac53af6e",
            "qualisys/Thibaud_iPhone4S_Dist_FrontPocket.mat": "266faf932311331dded830f1e1f878bb88cc18fbdfd433745b8e49553ac3d849",
            "qualisys/Thibaud_iPhone4S_NoDist_BackPocket.mat": "668597457c5520ef045608a5332825e530a886e9344ed05c534dc61288fb2618",
            "qualisys/Thibaud_iPhone4S_NoDist_FrontPocket.mat": "efaccc02c8bb40b7723148eeee4b8638ba84f18181339bedef3256c1ff0944f6",
            "qualisys/Thibaud_iPhone4S_NoDist_Phoning.mat": "95d8b8180b0144fb829bf52dfe336c8530bc98ab7c520ce9f090d0d2d2d09844",
            "qualisys/Thibaud_iPhone5_Dist_FrontPocket.mat": "e901553b348254f9496ce23e878c2eb66bb30f35b042ca53a81f0bd1e3788dc5",
            "qualisys/Thibaud_iPhone5_NoDist_BackPocket.mat": "4aa3c69d330309ceb45938f686ac4e52c56cd1883f51376e2c1a0b89a51c0f1d",
            "qualisys/Thibaud_iPhone5_NoDist_FrontPocket.mat": "e83169d5aa5ea183e1d3811dc4c957ac8357424b4d2f590a6d9cdffee6dab505",
            "qualisys/Thibaud_iPhone5_NoDist_Swinging.mat": "c798e162fb712e9e21b1de4fead45f8854c8c169d0392b385b615bdb02101129",
            "qualisys/Thibaud_iPhone5_NoDist_Texting.mat": "e9ca8a51bf270a0ba99891f103f61fcf61a48677cabe8b4facb32e62f6af0a61",
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
