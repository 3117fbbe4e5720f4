export { WebGLRenderer, Scene, PerspectiveCamera, BufferGeometry, BufferAttribute, Mesh, Line, LineSegments, LineBasicMaterial, ShaderMaterial, Vector2, Vector3, Color, Raycaster, Group, DoubleSide, Box3 } from "three";
export { OrbitControls } from "three/addons/controls/OrbitControls.js";
