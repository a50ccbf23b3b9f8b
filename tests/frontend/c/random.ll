; ModuleID = 'random.c'
source_filename = "random.c"
target datalayout = "e-m:e-p270:32:32-p271:32:32-p272:64:64-i64:64-f80:128-n8:16:32:64-S128"
target triple = "x86_64-pc-linux-gnu"

; Function Attrs: nofree norecurse nosync nounwind memory(read, argmem: readwrite, inaccessiblemem: none) uwtable
define dso_local i32 @f0(ptr noalias nocapture noundef %0, ptr noalias noundef %1, ptr noalias nocapture noundef %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #0 {
  %7 = getelementptr inbounds i32, ptr %0, i64 7
  %8 = load i32, ptr %7, align 4, !tbaa !5
  %9 = add i32 %8, 7
  %10 = xor i32 %8, %5
  %11 = icmp eq i32 %9, %10
  br i1 %11, label %12, label %24

12:                                               ; preds = %6
  %13 = getelementptr inbounds i32, ptr %1, i64 7
  %14 = load i32, ptr %13, align 4, !tbaa !5
  %15 = shl i32 %14, 4
  %16 = and i32 %5, 15
  %17 = zext i32 %16 to i64
  %18 = getelementptr inbounds i32, ptr %1, i64 %17
  store i32 %15, ptr %18, align 4, !tbaa !5
  %19 = mul i32 %8, 7
  %20 = xor i32 %19, -1
  %21 = getelementptr inbounds i32, ptr %0, i64 3
  store i32 %20, ptr %21, align 4, !tbaa !5
  %22 = getelementptr inbounds i32, ptr %1, i64 9
  %23 = load i32, ptr %22, align 4, !tbaa !5
  br label %96

24:                                               ; preds = %6
  %25 = getelementptr inbounds float, ptr %3, i64 14
  %26 = load float, ptr %25, align 4, !tbaa !9
  %27 = getelementptr inbounds float, ptr %3, i64 3
  %28 = load float, ptr %27, align 4, !tbaa !9
  %29 = fcmp oeq float %26, %28
  br i1 %29, label %30, label %102

30:                                               ; preds = %24
  %31 = sext i32 %4 to i64
  %32 = getelementptr inbounds i32, ptr %1, i64 %31
  %33 = icmp sgt i32 %4, 0
  br i1 %33, label %34, label %92

34:                                               ; preds = %30
  %35 = and i32 %4, 15
  %36 = zext i32 %35 to i64
  %37 = getelementptr inbounds i32, ptr %0, i64 %36
  %38 = getelementptr inbounds i32, ptr %0, i64 10
  br label %42

39:                                               ; preds = %89
  %40 = getelementptr inbounds i32, ptr %44, i64 1
  %41 = icmp ult ptr %40, %32
  br i1 %41, label %42, label %92, !llvm.loop !11

42:                                               ; preds = %34, %39
  %43 = phi i1 [ %33, %34 ], [ %41, %39 ]
  %44 = phi ptr [ %1, %34 ], [ %40, %39 ]
  %45 = phi i32 [ %8, %34 ], [ %90, %39 ]
  br label %46

46:                                               ; preds = %42, %81
  %47 = phi i64 [ 7, %42 ], [ %87, %81 ]
  %48 = phi i1 [ false, %42 ], [ %88, %81 ]
  %49 = phi i32 [ %45, %42 ], [ %86, %81 ]
  %50 = load i32, ptr %37, align 4, !tbaa !5
  %51 = getelementptr inbounds float, ptr %3, i64 %47
  %52 = load float, ptr %51, align 4, !tbaa !9
  %53 = fcmp olt float %52, 5.000000e-01
  br i1 %53, label %54, label %61

54:                                               ; preds = %46
  store i32 %4, ptr %38, align 4, !tbaa !5
  %55 = fadd float %52, -1.250000e+00
  %56 = load i32, ptr %44, align 4, !tbaa !5
  %57 = mul nsw i32 %56, 3
  %58 = and i32 %57, 15
  %59 = zext i32 %58 to i64
  %60 = getelementptr inbounds float, ptr %3, i64 %59
  store float %55, ptr %60, align 4, !tbaa !9
  br label %81

61:                                               ; preds = %46
  %62 = load i32, ptr %44, align 4, !tbaa !5
  %63 = add i32 %62, 14
  %64 = and i32 %63, 15
  %65 = zext i32 %64 to i64
  %66 = getelementptr inbounds i32, ptr %0, i64 %65
  store i32 %49, ptr %66, align 4, !tbaa !5
  %67 = add i32 %62, %49
  %68 = trunc i64 %47 to i32
  %69 = xor i32 %67, %68
  %70 = add nuw nsw i64 %47, 1
  %71 = getelementptr inbounds i32, ptr %2, i64 %70
  %72 = load i32, ptr %71, align 4, !tbaa !5
  %73 = and i32 %72, 15
  %74 = zext i32 %73 to i64
  %75 = getelementptr inbounds i32, ptr %2, i64 %74
  store i32 %69, ptr %75, align 4, !tbaa !5
  %76 = getelementptr inbounds float, ptr %3, i64 %70
  %77 = load float, ptr %76, align 4, !tbaa !9
  %78 = fcmp ole float %77, 5.000000e-01
  %79 = icmp ugt i32 %62, %49
  %80 = select i1 %78, i1 %79, i1 false
  br i1 %80, label %89, label %81

81:                                               ; preds = %61, %54
  %82 = add i32 %49, %5
  %83 = and i32 %82, 15
  %84 = zext i32 %83 to i64
  %85 = getelementptr inbounds i32, ptr %0, i64 %84
  %86 = load i32, ptr %85, align 4, !tbaa !5
  %87 = add nsw i64 %47, -1
  %88 = icmp ult i64 %47, 2
  br i1 %88, label %89, label %46, !llvm.loop !14

89:                                               ; preds = %61, %81
  %90 = phi i32 [ %49, %61 ], [ %86, %81 ]
  %91 = phi i1 [ %48, %61 ], [ %88, %81 ]
  br i1 %91, label %39, label %92

92:                                               ; preds = %89, %39, %30
  %93 = phi i1 [ %33, %30 ], [ %43, %89 ], [ %41, %39 ]
  %94 = phi i32 [ 1, %30 ], [ %50, %39 ], [ %50, %89 ]
  %95 = phi i32 [ %8, %30 ], [ %90, %39 ], [ %90, %89 ]
  br i1 %93, label %108, label %96

96:                                               ; preds = %92, %12
  %97 = phi i64 [ 3, %12 ], [ 13, %92 ]
  %98 = phi i32 [ %23, %12 ], [ 0, %92 ]
  %99 = phi i32 [ 1, %12 ], [ %94, %92 ]
  %100 = phi i32 [ %8, %12 ], [ %95, %92 ]
  %101 = getelementptr inbounds i32, ptr %1, i64 %97
  store i32 %98, ptr %101, align 4, !tbaa !5
  br label %102

102:                                              ; preds = %96, %24
  %103 = phi i32 [ 1, %24 ], [ %99, %96 ]
  %104 = phi i32 [ %8, %24 ], [ %100, %96 ]
  %105 = getelementptr inbounds i32, ptr %1, i64 15
  store i32 %103, ptr %105, align 4, !tbaa !5
  %106 = xor i32 %103, %104
  %107 = xor i32 %106, 7
  br label %108

108:                                              ; preds = %92, %102
  %109 = phi i32 [ %107, %102 ], [ 3670016, %92 ]
  ret i32 %109
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f1(ptr noalias noundef %0, ptr noalias nocapture noundef %1, ptr noalias nocapture noundef readnone %2, ptr noalias nocapture noundef readnone %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = getelementptr inbounds i32, ptr %0, i64 9
  %8 = load i32, ptr %7, align 4, !tbaa !5
  %9 = xor i32 %5, 7
  %10 = mul i32 %8, %9
  %11 = add i32 %5, 2
  %12 = and i32 %11, 15
  %13 = zext i32 %12 to i64
  %14 = getelementptr inbounds i32, ptr %1, i64 %13
  %15 = load i32, ptr %14, align 4, !tbaa !5
  %16 = icmp eq i32 %4, 0
  br i1 %16, label %28, label %17

17:                                               ; preds = %6
  %18 = and i32 %5, 1023
  %19 = add i32 %4, -1
  %20 = getelementptr inbounds i32, ptr %1, i64 13
  %21 = getelementptr inbounds i32, ptr %1, i64 6
  %22 = tail call i32 @llvm.smax.i32(i32 %19, i32 3)
  br label %23

23:                                               ; preds = %17, %65
  %24 = phi i32 [ 0, %17 ], [ %75, %65 ]
  %25 = phi i32 [ %15, %17 ], [ %67, %65 ]
  %26 = phi i32 [ %10, %17 ], [ %66, %65 ]
  %27 = and i32 %24, 1023
  br label %33

28:                                               ; preds = %65, %6
  %29 = phi i32 [ %10, %6 ], [ %66, %65 ]
  %30 = phi i32 [ %15, %6 ], [ %67, %65 ]
  %31 = xor i32 %29, %30
  %32 = xor i32 %31, 7
  ret i32 %32

33:                                               ; preds = %23, %60
  %34 = phi i32 [ %61, %60 ], [ %26, %23 ]
  %35 = phi i32 [ %62, %60 ], [ %25, %23 ]
  %36 = phi i32 [ %63, %60 ], [ 2, %23 ]
  %37 = or i32 %35, %24
  %38 = icmp slt i32 %36, %37
  br i1 %38, label %39, label %65

39:                                               ; preds = %33
  %40 = mul nsw i32 %36, 3
  %41 = and i32 %40, 15
  %42 = zext i32 %41 to i64
  %43 = getelementptr inbounds i32, ptr %0, i64 %42
  %44 = load i32, ptr %43, align 4, !tbaa !5
  %45 = and i32 %44, 3
  switch i32 %45, label %59 [
    i32 0, label %46
    i32 1, label %48
    i32 2, label %50
    i32 3, label %54
  ]

46:                                               ; preds = %39
  %47 = xor i32 %34, %18
  br label %60

48:                                               ; preds = %39
  %49 = xor i32 %34, %27
  br label %50

50:                                               ; preds = %39, %48
  %51 = phi i32 [ %34, %39 ], [ %49, %48 ]
  %52 = and i32 %35, 1023
  %53 = add nsw i32 %52, %35
  br label %54

54:                                               ; preds = %39, %50
  %55 = phi i32 [ %34, %39 ], [ %51, %50 ]
  %56 = phi i32 [ %35, %39 ], [ %53, %50 ]
  %57 = and i32 %56, 1023
  %58 = add nsw i32 %57, %56
  br label %60

59:                                               ; preds = %39
  unreachable

60:                                               ; preds = %46, %54
  %61 = phi i32 [ %55, %54 ], [ %47, %46 ]
  %62 = phi i32 [ %58, %54 ], [ %35, %46 ]
  %63 = add nuw nsw i32 %36, 1
  %64 = icmp eq i32 %63, %22
  br i1 %64, label %65, label %33, !llvm.loop !15

65:                                               ; preds = %33, %60
  %66 = phi i32 [ %34, %33 ], [ %61, %60 ]
  %67 = phi i32 [ %35, %33 ], [ %62, %60 ]
  %68 = load i32, ptr %7, align 4, !tbaa !5
  %69 = and i32 %24, 15
  %70 = zext i32 %69 to i64
  %71 = getelementptr inbounds i32, ptr %0, i64 %70
  store i32 %68, ptr %71, align 4, !tbaa !5
  %72 = load i32, ptr %20, align 4, !tbaa !5
  %73 = lshr i32 %24, 19
  %74 = add i32 %72, %73
  store i32 %74, ptr %21, align 4, !tbaa !5
  %75 = add nuw nsw i32 %24, 1
  %76 = icmp eq i32 %75, %4
  br i1 %76, label %28, label %23, !llvm.loop !16
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f2(ptr noalias nocapture noundef %0, ptr noalias nocapture noundef %1, ptr noalias nocapture noundef readonly %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = icmp sgt i32 %4, 0
  br i1 %7, label %8, label %23

8:                                                ; preds = %6
  %9 = add nsw i32 %5, -2
  %10 = sext i32 %9 to i64
  %11 = and i32 %4, 7
  %12 = zext i32 %11 to i64
  %13 = icmp sgt i32 %9, %11
  %14 = ashr i32 %4, 28
  %15 = getelementptr inbounds i32, ptr %1, i64 5
  %16 = icmp slt i32 %11, %9
  %17 = getelementptr inbounds i32, ptr %0, i64 3
  %18 = getelementptr inbounds i32, ptr %2, i64 1
  %19 = getelementptr inbounds i32, ptr %1, i64 2
  %20 = getelementptr inbounds float, ptr %3, i64 13
  %21 = sub i32 1, %4
  %22 = getelementptr inbounds i32, ptr %0, i64 2
  br label %29

23:                                               ; preds = %56, %6
  %24 = phi i32 [ 1, %6 ], [ %63, %56 ]
  %25 = srem i32 %4, 4
  %26 = sub i32 %25, %5
  store i32 0, ptr %1, align 4, !tbaa !5
  %27 = xor i32 %26, %24
  %28 = xor i32 %27, 7
  ret i32 %28

29:                                               ; preds = %8, %56
  %30 = phi i32 [ 0, %8 ], [ %64, %56 ]
  %31 = phi i32 [ 1, %8 ], [ %63, %56 ]
  %32 = add nuw nsw i32 %30, 2
  %33 = and i32 %32, 15
  %34 = zext i32 %33 to i64
  %35 = getelementptr inbounds i32, ptr %1, i64 %34
  %36 = load i32, ptr %35, align 4, !tbaa !5
  %37 = mul nuw nsw i32 %30, 3
  %38 = and i32 %37, 15
  %39 = zext i32 %38 to i64
  %40 = getelementptr inbounds i32, ptr %0, i64 %39
  store i32 %36, ptr %40, align 4, !tbaa !5
  %41 = icmp eq i32 %30, 0
  br i1 %41, label %56, label %42

42:                                               ; preds = %29
  %43 = add nuw i32 %30, 15
  %44 = and i32 %43, 15
  %45 = zext i32 %44 to i64
  %46 = getelementptr inbounds i32, ptr %0, i64 %45
  %47 = getelementptr inbounds i32, ptr %1, i64 %39
  %48 = and i32 %30, 15
  %49 = zext i32 %48 to i64
  %50 = getelementptr inbounds float, ptr %3, i64 %49
  %51 = getelementptr inbounds i32, ptr %2, i64 %39
  %52 = lshr i32 %30, 18
  %53 = and i32 %30, 15
  %54 = zext i32 %53 to i64
  %55 = getelementptr inbounds i32, ptr %1, i64 %54
  br label %66

56:                                               ; preds = %137, %29
  %57 = load i32, ptr %22, align 4, !tbaa !5
  %58 = add nuw i32 %30, 15
  %59 = and i32 %58, 15
  %60 = zext i32 %59 to i64
  %61 = getelementptr inbounds i32, ptr %0, i64 %60
  %62 = load i32, ptr %61, align 4, !tbaa !5
  %63 = sub i32 %57, %62
  %64 = add nuw nsw i32 %30, 1
  %65 = icmp eq i32 %64, %4
  br i1 %65, label %23, label %29, !llvm.loop !17

66:                                               ; preds = %42, %137
  %67 = phi i32 [ 0, %42 ], [ %139, %137 ]
  %68 = phi i32 [ %31, %42 ], [ %138, %137 ]
  store i32 %5, ptr %46, align 4, !tbaa !5
  br i1 %13, label %69, label %81

69:                                               ; preds = %81, %66
  %70 = phi i32 [ %68, %66 ], [ %88, %81 ]
  br i1 %16, label %137, label %71

71:                                               ; preds = %69
  %72 = load i32, ptr %17, align 4, !tbaa !5
  %73 = load i32, ptr %18, align 4, !tbaa !5
  %74 = add i32 %73, %72
  %75 = and i32 %73, 255
  %76 = sitofp i32 %75 to float
  %77 = and i32 %67, 14
  %78 = or i32 %77, 1
  %79 = zext i32 %78 to i64
  %80 = getelementptr inbounds float, ptr %3, i64 %79
  br label %91

81:                                               ; preds = %66, %81
  %82 = phi i64 [ %89, %81 ], [ %10, %66 ]
  %83 = phi i32 [ %88, %81 ], [ %68, %66 ]
  %84 = load i32, ptr %47, align 4, !tbaa !5
  store i32 %84, ptr %15, align 4, !tbaa !5
  %85 = trunc i64 %82 to i32
  %86 = lshr i32 %85, 19
  %87 = xor i32 %83, %14
  %88 = xor i32 %87, %86
  %89 = add nsw i64 %82, 2
  %90 = icmp sgt i64 %89, %12
  br i1 %90, label %69, label %81, !llvm.loop !18

91:                                               ; preds = %71, %131
  %92 = phi i32 [ %11, %71 ], [ %135, %131 ]
  %93 = phi i32 [ %70, %71 ], [ %132, %131 ]
  store i32 %74, ptr %19, align 4, !tbaa !5
  %94 = icmp uge i32 %30, %92
  %95 = and i32 %92, %30
  %96 = icmp ugt i32 %30, %95
  %97 = or i1 %94, %96
  br i1 %97, label %131, label %98

98:                                               ; preds = %91
  %99 = load float, ptr %50, align 4, !tbaa !9
  %100 = fcmp ugt float %99, 1.000000e+00
  br i1 %100, label %101, label %137

101:                                              ; preds = %98
  %102 = and i32 %92, 15
  %103 = zext i32 %102 to i64
  %104 = getelementptr inbounds float, ptr %3, i64 %103
  %105 = load float, ptr %104, align 4, !tbaa !9
  %106 = fcmp oeq float %105, 1.000000e+00
  %107 = icmp sgt i32 %30, %92
  %108 = select i1 %106, i1 %107, i1 false
  br i1 %108, label %109, label %114

109:                                              ; preds = %101
  %110 = and i32 %93, %5
  %111 = icmp sgt i32 %110, -3
  %112 = select i1 %111, i32 0, i32 %93
  %113 = add i32 %112, %92
  br label %123

114:                                              ; preds = %101
  %115 = load i32, ptr %51, align 4, !tbaa !5
  %116 = icmp slt i32 %115, %67
  br i1 %116, label %120, label %117

117:                                              ; preds = %114
  %118 = load float, ptr %20, align 4, !tbaa !9
  %119 = fmul float %118, %76
  store float %119, ptr %80, align 4, !tbaa !9
  br label %120

120:                                              ; preds = %117, %114
  %121 = getelementptr inbounds i32, ptr %0, i64 %103
  %122 = load i32, ptr %121, align 4, !tbaa !5
  br label %123

123:                                              ; preds = %109, %120
  %124 = phi i32 [ %113, %109 ], [ %122, %120 ]
  %125 = phi i32 [ %52, %109 ], [ 0, %120 ]
  %126 = phi i32 [ %112, %109 ], [ %21, %120 ]
  %127 = and i32 %124, 15
  %128 = zext i32 %127 to i64
  %129 = getelementptr inbounds i32, ptr %1, i64 %128
  store i32 %125, ptr %129, align 4, !tbaa !5
  %130 = getelementptr inbounds i32, ptr %1, i64 %103
  store i32 %5, ptr %130, align 4, !tbaa !5
  br label %131

131:                                              ; preds = %123, %91
  %132 = phi i32 [ %126, %123 ], [ %93, %91 ]
  %133 = mul i32 %92, %5
  %134 = and i32 %133, -7
  store i32 %134, ptr %55, align 4, !tbaa !5
  %135 = add nsw i32 %92, -3
  %136 = icmp slt i32 %135, %9
  br i1 %136, label %137, label %91, !llvm.loop !19

137:                                              ; preds = %131, %98, %69
  %138 = phi i32 [ %70, %69 ], [ %132, %131 ], [ %93, %98 ]
  %139 = add nuw nsw i32 %67, 2
  %140 = icmp ult i32 %139, %30
  br i1 %140, label %66, label %56, !llvm.loop !20
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f3(ptr noalias noundef writeonly %0, ptr noalias nocapture noundef %1, ptr noalias nocapture noundef readnone %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = icmp sgt i32 %5, -1
  br i1 %7, label %8, label %57

8:                                                ; preds = %6
  %9 = xor i32 %4, -2
  %10 = sext i32 %4 to i64
  %11 = getelementptr inbounds i32, ptr %0, i64 %10
  %12 = icmp sgt i32 %4, 0
  %13 = add i32 %5, %4
  %14 = and i32 %13, 15
  %15 = zext i32 %14 to i64
  %16 = getelementptr inbounds i32, ptr %1, i64 %15
  br label %17

17:                                               ; preds = %31, %8
  %18 = phi i32 [ %5, %8 ], [ %44, %31 ]
  %19 = phi i32 [ %4, %8 ], [ %33, %31 ]
  %20 = phi i32 [ 1, %8 ], [ %32, %31 ]
  %21 = xor i32 %18, 7
  %22 = or i32 %21, %9
  %23 = mul nsw i32 %18, 3
  %24 = and i32 %23, 15
  %25 = zext i32 %24 to i64
  %26 = getelementptr inbounds i32, ptr %1, i64 %25
  store i32 %22, ptr %26, align 4, !tbaa !5
  %27 = and i32 %20, 1023
  %28 = add nsw i32 %19, %27
  br i1 %12, label %29, label %31

29:                                               ; preds = %17
  %30 = icmp sgt i32 %22, %18
  br label %47

31:                                               ; preds = %53, %17
  %32 = phi i32 [ %20, %17 ], [ %54, %53 ]
  %33 = phi i32 [ %28, %17 ], [ %50, %53 ]
  %34 = add nsw i32 %18, 2
  %35 = and i32 %34, 15
  %36 = zext i32 %35 to i64
  %37 = getelementptr inbounds i32, ptr %0, i64 %36
  store i32 %22, ptr %37, align 4, !tbaa !5
  %38 = add nsw i32 %18, 3
  %39 = and i32 %38, 15
  %40 = zext i32 %39 to i64
  %41 = getelementptr inbounds i32, ptr %1, i64 %40
  %42 = load i32, ptr %41, align 4, !tbaa !5
  %43 = icmp ugt i32 %42, 8
  %44 = add nsw i32 %18, -3
  %45 = icmp sgt i32 %18, 2
  %46 = select i1 %43, i1 %45, i1 false
  br i1 %46, label %17, label %57, !llvm.loop !21

47:                                               ; preds = %29, %53
  %48 = phi ptr [ %0, %29 ], [ %55, %53 ]
  %49 = phi i32 [ %28, %29 ], [ %50, %53 ]
  %50 = xor i32 %49, 5
  br i1 %30, label %53, label %51

51:                                               ; preds = %47
  %52 = load i32, ptr %16, align 4, !tbaa !5
  br label %53

53:                                               ; preds = %47, %51
  %54 = phi i32 [ %52, %51 ], [ 7, %47 ]
  %55 = getelementptr inbounds i32, ptr %48, i64 1
  %56 = icmp ult ptr %55, %11
  br i1 %56, label %47, label %31, !llvm.loop !22

57:                                               ; preds = %31, %6
  %58 = phi i32 [ 1, %6 ], [ %32, %31 ]
  %59 = phi i32 [ %4, %6 ], [ %33, %31 ]
  %60 = getelementptr inbounds float, ptr %3, i64 1
  %61 = load float, ptr %60, align 4, !tbaa !9
  %62 = getelementptr inbounds float, ptr %3, i64 2
  %63 = load float, ptr %62, align 4, !tbaa !9
  %64 = fadd float %61, %63
  %65 = getelementptr inbounds float, ptr %3, i64 5
  store float %64, ptr %65, align 4, !tbaa !9
  %66 = and i32 %58, 2
  %67 = or i32 %66, 49
  %68 = xor i32 %59, %67
  %69 = xor i32 %68, %58
  ret i32 %69
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f4(ptr noalias nocapture noundef readonly %0, ptr noalias nocapture noundef %1, ptr noalias nocapture noundef %2, ptr noalias nocapture noundef readnone %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = sext i32 %5 to i64
  %8 = icmp sgt i32 %5, 1
  br i1 %8, label %9, label %18

9:                                                ; preds = %6
  %10 = getelementptr inbounds i32, ptr %0, i64 8
  %11 = load i32, ptr %10, align 4, !tbaa !5
  %12 = and i32 %11, 15
  %13 = zext i32 %12 to i64
  %14 = getelementptr inbounds i32, ptr %0, i64 %13
  %15 = load i32, ptr %14, align 4, !tbaa !5
  %16 = or i32 %4, 7
  %17 = mul i32 %15, %16
  br label %24

18:                                               ; preds = %24, %6
  %19 = load i32, ptr %2, align 4, !tbaa !5
  %20 = add i32 %19, %4
  store i32 %20, ptr %2, align 4, !tbaa !5
  %21 = icmp slt i32 %4, 0
  br i1 %21, label %30, label %22

22:                                               ; preds = %18
  %23 = icmp eq i32 %4, 0
  br label %35

24:                                               ; preds = %9, %24
  %25 = phi i64 [ 1, %9 ], [ %28, %24 ]
  %26 = and i64 %25, 15
  %27 = getelementptr inbounds i32, ptr %1, i64 %26
  store i32 %17, ptr %27, align 4, !tbaa !5
  %28 = add nuw nsw i64 %25, 2
  %29 = icmp slt i64 %28, %7
  br i1 %29, label %24, label %18, !llvm.loop !23

30:                                               ; preds = %46, %18
  %31 = phi i32 [ %4, %18 ], [ %37, %46 ]
  %32 = phi i32 [ 1, %18 ], [ %43, %46 ]
  %33 = xor i32 %31, %32
  %34 = xor i32 %33, 7
  ret i32 %34

35:                                               ; preds = %22, %46
  %36 = phi i32 [ 0, %22 ], [ %47, %46 ]
  %37 = phi i32 [ 1, %22 ], [ %43, %46 ]
  %38 = mul nuw nsw i32 %36, 3
  %39 = and i32 %38, 15
  %40 = zext i32 %39 to i64
  %41 = getelementptr inbounds i32, ptr %1, i64 %40
  %42 = load i32, ptr %41, align 4, !tbaa !5
  %43 = and i32 %42, %37
  br i1 %23, label %46, label %44

44:                                               ; preds = %35
  %45 = mul i32 %36, %5
  br label %49

46:                                               ; preds = %49, %35
  %47 = add nuw nsw i32 %36, 3
  %48 = icmp sgt i32 %47, %4
  br i1 %48, label %30, label %35, !llvm.loop !24

49:                                               ; preds = %44, %49
  %50 = phi i32 [ 0, %44 ], [ %56, %49 ]
  %51 = and i32 %50, 15
  %52 = zext i32 %51 to i64
  %53 = getelementptr inbounds i32, ptr %2, i64 %52
  %54 = load i32, ptr %53, align 4, !tbaa !5
  %55 = add i32 %54, %45
  store i32 %55, ptr %53, align 4, !tbaa !5
  %56 = add i32 %50, 3
  %57 = icmp ult i32 %56, %4
  br i1 %57, label %49, label %46, !llvm.loop !25
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f5(ptr noalias nocapture noundef readonly %0, ptr noalias nocapture noundef readonly %1, ptr noalias nocapture noundef writeonly %2, ptr noalias nocapture noundef readnone %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = getelementptr inbounds i32, ptr %0, i64 3
  %8 = load i32, ptr %7, align 4, !tbaa !5
  %9 = and i32 %8, 3
  br label %10

10:                                               ; preds = %40, %6
  %11 = phi i64 [ %45, %40 ], [ 1, %6 ]
  %12 = phi i32 [ %24, %40 ], [ 1, %6 ]
  %13 = phi i32 [ %25, %40 ], [ %4, %6 ]
  switch i32 %9, label %21 [
    i32 0, label %14
    i32 1, label %17
    i32 2, label %19
  ]

14:                                               ; preds = %10
  %15 = and i32 %13, 1023
  %16 = add nsw i32 %15, %13
  br label %23

17:                                               ; preds = %10
  %18 = xor i32 %12, 7
  br label %23

19:                                               ; preds = %10
  %20 = add nsw i32 %12, 7
  br label %23

21:                                               ; preds = %10
  %22 = xor i32 %13, 5
  br label %23

23:                                               ; preds = %21, %19, %17, %14
  %24 = phi i32 [ %12, %21 ], [ %20, %19 ], [ %18, %17 ], [ %12, %14 ]
  %25 = phi i32 [ %22, %21 ], [ %13, %19 ], [ %13, %17 ], [ %16, %14 ]
  %26 = getelementptr inbounds i32, ptr %1, i64 %11
  %27 = load i32, ptr %26, align 4, !tbaa !5
  %28 = add nuw i64 %11, 14
  %29 = and i64 %28, 15
  %30 = getelementptr inbounds i32, ptr %0, i64 %29
  %31 = load i32, ptr %30, align 4, !tbaa !5
  %32 = icmp sgt i32 %27, %31
  br i1 %32, label %33, label %38

33:                                               ; preds = %23
  %34 = add nuw nsw i64 %11, 15
  %35 = and i64 %34, 15
  %36 = getelementptr inbounds i32, ptr %1, i64 %35
  %37 = load i32, ptr %36, align 4, !tbaa !5
  br label %40

38:                                               ; preds = %23
  %39 = sub i32 -9, %24
  br label %40

40:                                               ; preds = %38, %33
  %41 = phi i32 [ %37, %33 ], [ %39, %38 ]
  %42 = mul i64 %11, 3
  %43 = and i64 %42, 15
  %44 = getelementptr inbounds i32, ptr %2, i64 %43
  store i32 %41, ptr %44, align 4, !tbaa !5
  %45 = add nuw nsw i64 %11, 1
  %46 = icmp eq i64 %45, 12
  br i1 %46, label %47, label %10, !llvm.loop !26

47:                                               ; preds = %40
  %48 = add i32 %5, -2
  %49 = and i32 %48, 15
  %50 = zext i32 %49 to i64
  %51 = getelementptr inbounds i32, ptr %0, i64 %50
  %52 = load i32, ptr %51, align 4, !tbaa !5
  %53 = add i32 %52, 35
  %54 = and i32 %4, 3
  switch i32 %54, label %64 [
    i32 0, label %55
    i32 1, label %58
    i32 2, label %61
  ]

55:                                               ; preds = %47
  %56 = and i32 %25, 1023
  %57 = add nsw i32 %56, %24
  br label %66

58:                                               ; preds = %47
  %59 = and i32 %4, 1023
  %60 = add nsw i32 %25, %59
  br label %66

61:                                               ; preds = %47
  %62 = and i32 %5, 1023
  %63 = add nsw i32 %24, %62
  br label %66

64:                                               ; preds = %47
  %65 = xor i32 %24, 5
  br label %66

66:                                               ; preds = %64, %61, %58, %55
  %67 = phi i32 [ %57, %55 ], [ %24, %58 ], [ %63, %61 ], [ %65, %64 ]
  %68 = phi i32 [ %25, %55 ], [ %60, %58 ], [ %25, %61 ], [ %25, %64 ]
  br label %69

69:                                               ; preds = %66, %69
  %70 = phi i32 [ %53, %69 ], [ %67, %66 ]
  %71 = phi i32 [ %53, %69 ], [ %68, %66 ]
  %72 = phi i32 [ %74, %69 ], [ %4, %66 ]
  %73 = icmp sgt i32 %72, %48
  %74 = add nsw i32 %72, -1
  br i1 %73, label %69, label %75, !llvm.loop !27

75:                                               ; preds = %69
  %76 = xor i32 %70, %71
  %77 = xor i32 %76, %53
  ret i32 %77
}

; Function Attrs: nofree norecurse nosync nounwind memory(read, argmem: readwrite, inaccessiblemem: none) uwtable
define dso_local i32 @f6(ptr noalias nocapture noundef %0, ptr noalias noundef %1, ptr noalias nocapture noundef %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #0 {
  %7 = sext i32 %4 to i64
  %8 = getelementptr inbounds i32, ptr %1, i64 %7
  %9 = icmp eq i32 %4, 0
  %10 = ashr i32 %4, 15
  %11 = getelementptr inbounds i32, ptr %1, i64 8
  %12 = getelementptr inbounds i32, ptr %0, i64 14
  %13 = getelementptr inbounds i32, ptr %1, i64 2
  %14 = getelementptr inbounds float, ptr %3, i64 3
  %15 = ashr i32 %5, 10
  %16 = getelementptr inbounds i32, ptr %0, i64 7
  %17 = getelementptr inbounds i32, ptr %0, i64 3
  br label %18

18:                                               ; preds = %6, %184
  %19 = phi i64 [ 0, %6 ], [ %192, %184 ]
  %20 = phi i64 [ 1, %6 ], [ %194, %184 ]
  %21 = phi i1 [ false, %6 ], [ %193, %184 ]
  %22 = phi i32 [ 7, %6 ], [ %118, %184 ]
  %23 = phi i32 [ %4, %6 ], [ %117, %184 ]
  %24 = phi i32 [ 1, %6 ], [ %116, %184 ]
  %25 = phi i32 [ undef, %6 ], [ %115, %184 ]
  br i1 %9, label %113, label %26

26:                                               ; preds = %18
  %27 = icmp eq i64 %19, 0
  %28 = mul i64 %19, 3
  %29 = and i64 %28, 15
  %30 = getelementptr inbounds i32, ptr %2, i64 %29
  %31 = trunc i64 %19 to i32
  %32 = lshr i32 %31, 1
  %33 = trunc i64 %19 to i32
  %34 = add i32 %33, 1
  %35 = trunc i64 %19 to i32
  %36 = sub i32 -5, %35
  br label %37

37:                                               ; preds = %26, %110
  %38 = phi i1 [ %9, %26 ], [ %112, %110 ]
  %39 = phi ptr [ %1, %26 ], [ %111, %110 ]
  %40 = phi i32 [ %22, %26 ], [ %49, %110 ]
  %41 = phi i32 [ %23, %26 ], [ %48, %110 ]
  %42 = phi i32 [ %24, %26 ], [ %47, %110 ]
  br i1 %27, label %46, label %43

43:                                               ; preds = %37
  %44 = load i32, ptr %30, align 4, !tbaa !5
  %45 = icmp eq i32 %10, %44
  br label %51

46:                                               ; preds = %97, %37
  %47 = phi i32 [ %42, %37 ], [ %98, %97 ]
  %48 = phi i32 [ %41, %37 ], [ %99, %97 ]
  %49 = phi i32 [ %40, %37 ], [ %100, %97 ]
  %50 = icmp sgt i32 %47, %36
  br i1 %50, label %110, label %103

51:                                               ; preds = %43, %97
  %52 = phi i64 [ 1, %43 ], [ %101, %97 ]
  %53 = phi i32 [ %40, %43 ], [ %100, %97 ]
  %54 = phi i32 [ %41, %43 ], [ %99, %97 ]
  %55 = phi i32 [ %42, %43 ], [ %98, %97 ]
  %56 = load i32, ptr %39, align 4, !tbaa !5
  %57 = srem i32 %53, 8
  %58 = xor i32 %57, %55
  %59 = xor i32 %58, %56
  br i1 %45, label %60, label %72

60:                                               ; preds = %51
  %61 = mul i32 %53, 3
  %62 = mul i32 %56, %5
  %63 = add i32 %62, %61
  %64 = xor i32 %59, %32
  %65 = or i32 %63, -5
  %66 = icmp slt i32 %65, %54
  br i1 %66, label %67, label %97

67:                                               ; preds = %60
  store i32 %54, ptr %12, align 4, !tbaa !5
  %68 = load i32, ptr %13, align 4, !tbaa !5
  %69 = srem i32 %68, 8
  %70 = add nuw nsw i64 %52, 1
  %71 = getelementptr inbounds i32, ptr %1, i64 %70
  store i32 %69, ptr %71, align 4, !tbaa !5
  br label %97

72:                                               ; preds = %51
  %73 = and i32 %54, 15
  %74 = zext i32 %73 to i64
  %75 = getelementptr inbounds i32, ptr %2, i64 %74
  %76 = load i32, ptr %75, align 4, !tbaa !5
  %77 = sext i32 %54 to i64
  %78 = icmp slt i64 %19, %77
  %79 = select i1 %78, i32 6, i32 %59
  %80 = icmp sgt i32 %76, %79
  %81 = add i32 %56, 5
  %82 = select i1 %80, i32 %34, i32 %81
  store i32 %82, ptr %11, align 4, !tbaa !5
  %83 = getelementptr inbounds i32, ptr %2, i64 %52
  %84 = load i32, ptr %83, align 4, !tbaa !5
  %85 = and i32 %84, 7
  switch i32 %85, label %94 [
    i32 0, label %86
    i32 1, label %89
    i32 2, label %91
  ]

86:                                               ; preds = %72
  %87 = and i32 %53, 1023
  %88 = xor i32 %87, %54
  br label %97

89:                                               ; preds = %72
  %90 = xor i32 %54, 4
  br label %97

91:                                               ; preds = %72
  %92 = and i32 %53, 1023
  %93 = add nsw i32 %59, %92
  br label %94

94:                                               ; preds = %72, %91
  %95 = phi i32 [ %59, %72 ], [ %93, %91 ]
  %96 = xor i32 %95, 5
  br label %97

97:                                               ; preds = %86, %89, %94, %67, %60
  %98 = phi i32 [ %64, %67 ], [ %64, %60 ], [ %96, %94 ], [ %59, %89 ], [ %59, %86 ]
  %99 = phi i32 [ %54, %67 ], [ %54, %60 ], [ %54, %94 ], [ %90, %89 ], [ %88, %86 ]
  %100 = phi i32 [ %63, %67 ], [ %63, %60 ], [ %53, %94 ], [ %53, %89 ], [ %53, %86 ]
  %101 = add nuw nsw i64 %52, 1
  %102 = icmp eq i64 %101, %20
  br i1 %102, label %46, label %51, !llvm.loop !28

103:                                              ; preds = %46
  %104 = load i32, ptr %39, align 4, !tbaa !5
  %105 = mul nsw i32 %104, 3
  %106 = and i32 %105, 15
  %107 = zext i32 %106 to i64
  %108 = getelementptr inbounds i32, ptr %2, i64 %107
  %109 = load i32, ptr %108, align 4, !tbaa !5
  br label %113

110:                                              ; preds = %46
  %111 = getelementptr inbounds i32, ptr %39, i64 1
  %112 = icmp eq ptr %111, %8
  br i1 %112, label %113, label %37, !llvm.loop !29

113:                                              ; preds = %110, %18, %103
  %114 = phi i1 [ %38, %103 ], [ %9, %18 ], [ %112, %110 ]
  %115 = phi i32 [ %109, %103 ], [ %25, %18 ], [ %25, %110 ]
  %116 = phi i32 [ %47, %103 ], [ %24, %18 ], [ %47, %110 ]
  %117 = phi i32 [ %48, %103 ], [ %23, %18 ], [ %48, %110 ]
  %118 = phi i32 [ %49, %103 ], [ %22, %18 ], [ %49, %110 ]
  br i1 %114, label %119, label %196

119:                                              ; preds = %113
  %120 = sub i32 %5, %118
  %121 = trunc i64 %19 to i32
  %122 = xor i32 %121, -2
  %123 = icmp eq i32 %120, %122
  br i1 %123, label %124, label %184

124:                                              ; preds = %119
  %125 = getelementptr inbounds i32, ptr %0, i64 %19
  store i32 %4, ptr %125, align 4, !tbaa !5
  %126 = icmp sgt i32 %118, %5
  br i1 %126, label %134, label %127

127:                                              ; preds = %124
  %128 = add nuw i64 %19, 14
  %129 = and i64 %128, 15
  %130 = getelementptr inbounds float, ptr %3, i64 %129
  %131 = load float, ptr %130, align 4, !tbaa !9
  %132 = load float, ptr %14, align 4, !tbaa !9
  %133 = fcmp olt float %131, %132
  br i1 %133, label %134, label %138

134:                                              ; preds = %127, %124
  %135 = icmp eq i32 %118, 4
  %136 = select i1 %135, i32 4, i32 %4
  %137 = add i32 %136, %116
  br label %196

138:                                              ; preds = %127
  %139 = getelementptr inbounds float, ptr %3, i64 %19
  %140 = load float, ptr %139, align 4, !tbaa !9
  %141 = fcmp olt float %140, 5.000000e-01
  br i1 %141, label %142, label %184

142:                                              ; preds = %138
  %143 = load float, ptr %3, align 4, !tbaa !9
  %144 = fcmp ugt float %143, 1.000000e+00
  br i1 %144, label %157, label %145

145:                                              ; preds = %142
  %146 = mul i64 %19, 3
  %147 = and i64 %146, 15
  %148 = getelementptr inbounds i32, ptr %0, i64 %147
  %149 = load i32, ptr %148, align 4, !tbaa !5
  %150 = and i32 %149, 15
  %151 = zext i32 %150 to i64
  %152 = getelementptr inbounds float, ptr %3, i64 %151
  %153 = load float, ptr %152, align 4, !tbaa !9
  %154 = and i32 %117, 255
  %155 = sitofp i32 %154 to float
  %156 = fsub float %153, %155
  store float %156, ptr %139, align 4, !tbaa !9
  br label %157

157:                                              ; preds = %145, %142
  %158 = add nuw i64 %19, 15
  %159 = and i64 %158, 15
  %160 = getelementptr inbounds i32, ptr %0, i64 %159
  %161 = load i32, ptr %160, align 4, !tbaa !5
  %162 = icmp slt i32 %161, %15
  br i1 %162, label %163, label %167

163:                                              ; preds = %157
  %164 = mul i64 %19, 3
  %165 = and i64 %164, 15
  %166 = getelementptr inbounds i32, ptr %1, i64 %165
  store i32 %118, ptr %166, align 4, !tbaa !5
  br label %184

167:                                              ; preds = %157
  %168 = getelementptr inbounds i32, ptr %2, i64 %19
  %169 = load i32, ptr %168, align 4, !tbaa !5
  %170 = add i32 %169, %5
  store i32 %170, ptr %168, align 4, !tbaa !5
  %171 = trunc i64 %19 to i32
  %172 = add i32 %118, %171
  %173 = and i32 %172, 15
  %174 = zext i32 %173 to i64
  %175 = getelementptr inbounds i32, ptr %0, i64 %174
  %176 = load i32, ptr %175, align 4, !tbaa !5
  %177 = and i32 %176, 15
  %178 = zext i32 %177 to i64
  %179 = getelementptr inbounds float, ptr %3, i64 %178
  %180 = load float, ptr %179, align 4, !tbaa !9
  %181 = fcmp olt float %180, 5.000000e-01
  br i1 %181, label %182, label %184

182:                                              ; preds = %167
  %183 = load i32, ptr %16, align 4, !tbaa !5
  store i32 %183, ptr %17, align 4, !tbaa !5
  br label %184

184:                                              ; preds = %138, %167, %182, %163, %119
  %185 = add i32 %116, %4
  %186 = icmp slt i32 %116, 0
  %187 = trunc i64 %19 to i32
  %188 = select i1 %186, i32 %187, i32 %117
  %189 = mul i32 %188, %185
  %190 = add nuw nsw i64 %19, 2
  %191 = getelementptr inbounds i32, ptr %0, i64 %190
  store i32 %189, ptr %191, align 4, !tbaa !5
  %192 = add nuw nsw i64 %19, 1
  %193 = icmp ugt i64 %19, 10
  %194 = add nuw nsw i64 %20, 1
  %195 = icmp eq i64 %192, 12
  br i1 %195, label %196, label %18, !llvm.loop !30

196:                                              ; preds = %184, %113, %134
  %197 = phi i1 [ %21, %134 ], [ %193, %184 ], [ %21, %113 ]
  %198 = phi i32 [ %137, %134 ], [ %115, %113 ], [ %115, %184 ]
  br i1 %197, label %199, label %224

199:                                              ; preds = %196
  %200 = icmp sgt i32 %118, %4
  %201 = select i1 %200, i32 %116, i32 %118
  %202 = add i32 %5, -2
  br label %207

203:                                              ; preds = %207
  %204 = ashr i32 %201, 12
  %205 = xor i32 %204, %118
  %206 = xor i32 %205, %212
  br label %224

207:                                              ; preds = %199, %207
  %208 = phi i32 [ 1, %199 ], [ %222, %207 ]
  %209 = phi i32 [ %116, %199 ], [ %212, %207 ]
  %210 = or i32 %208, %5
  %211 = xor i32 %209, %202
  %212 = xor i32 %211, %210
  %213 = mul nuw nsw i32 %208, 3
  %214 = and i32 %213, 15
  %215 = zext i32 %214 to i64
  %216 = getelementptr inbounds i32, ptr %0, i64 %215
  %217 = load i32, ptr %216, align 4, !tbaa !5
  %218 = mul i32 %217, %4
  %219 = getelementptr inbounds i32, ptr %2, i64 %215
  %220 = load i32, ptr %219, align 4, !tbaa !5
  %221 = add i32 %220, %218
  store i32 %221, ptr %219, align 4, !tbaa !5
  %222 = add nuw nsw i32 %208, 1
  %223 = icmp eq i32 %222, 9
  br i1 %223, label %203, label %207, !llvm.loop !31

224:                                              ; preds = %196, %203
  %225 = phi i32 [ %206, %203 ], [ %198, %196 ]
  ret i32 %225
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f7(ptr noalias nocapture noundef writeonly %0, ptr noalias nocapture noundef readnone %1, ptr noalias nocapture noundef %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = icmp sgt i32 %4, 0
  br i1 %7, label %8, label %11

8:                                                ; preds = %6
  %9 = and i32 %4, 255
  %10 = sitofp i32 %9 to float
  br label %25

11:                                               ; preds = %25, %6
  %12 = and i32 %4, 1
  %13 = zext i32 %12 to i64
  %14 = getelementptr inbounds i32, ptr %0, i64 %13
  store i32 -6, ptr %14, align 4, !tbaa !5
  %15 = getelementptr inbounds i32, ptr %2, i64 5
  %16 = load i32, ptr %15, align 4, !tbaa !5
  %17 = add i32 %16, -7
  store i32 %17, ptr %15, align 4, !tbaa !5
  %18 = and i32 %4, 255
  %19 = sitofp i32 %18 to float
  %20 = add i32 %4, 9
  %21 = and i32 %20, 15
  %22 = zext i32 %21 to i64
  %23 = getelementptr inbounds i32, ptr %2, i64 %22
  %24 = load i32, ptr %23, align 4, !tbaa !5
  br label %37

25:                                               ; preds = %8, %25
  %26 = phi i32 [ 0, %8 ], [ %32, %25 ]
  %27 = and i32 %26, 15
  %28 = zext i32 %27 to i64
  %29 = getelementptr inbounds float, ptr %3, i64 %28
  %30 = load float, ptr %29, align 4, !tbaa !9
  %31 = fsub float %30, %10
  store float %31, ptr %29, align 4, !tbaa !9
  %32 = add nuw nsw i32 %26, 1
  %33 = icmp eq i32 %32, %4
  br i1 %33, label %11, label %25, !llvm.loop !32

34:                                               ; preds = %37
  %35 = add i32 %24, 25
  store i32 %35, ptr %23, align 4, !tbaa !5
  %36 = xor i32 %4, 6
  ret i32 %36

37:                                               ; preds = %11, %37
  %38 = phi i64 [ 1, %11 ], [ %39, %37 ]
  %39 = add nuw nsw i64 %38, 2
  %40 = getelementptr inbounds float, ptr %3, i64 %39
  %41 = load float, ptr %40, align 4, !tbaa !9
  %42 = fmul float %41, %19
  %43 = getelementptr inbounds float, ptr %3, i64 %38
  store float %42, ptr %43, align 4, !tbaa !9
  %44 = icmp ult i64 %38, 8
  br i1 %44, label %37, label %34, !llvm.loop !33
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f8(ptr noalias nocapture noundef %0, ptr noalias nocapture noundef %1, ptr noalias nocapture noundef %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = icmp sgt i32 %5, 1
  br i1 %7, label %8, label %64

8:                                                ; preds = %6
  %9 = and i32 %5, 2
  %10 = add i32 %9, %4
  %11 = add i32 %5, -2
  %12 = icmp slt i32 %5, 15
  %13 = add nsw i32 %4, -1
  %14 = icmp sgt i32 %4, 2
  %15 = getelementptr inbounds i32, ptr %2, i64 13
  %16 = getelementptr inbounds i32, ptr %2, i64 1
  %17 = load i32, ptr %16, align 4, !tbaa !5
  %18 = icmp sgt i32 %17, -3
  br i1 %18, label %28, label %64

19:                                               ; preds = %52, %28
  %20 = phi i32 [ %29, %28 ], [ 0, %52 ]
  %21 = icmp eq i32 %31, %5
  br i1 %21, label %62, label %22, !llvm.loop !34

22:                                               ; preds = %19
  %23 = and i32 %20, 7
  %24 = zext i32 %23 to i64
  %25 = getelementptr inbounds i32, ptr %2, i64 %24
  %26 = load i32, ptr %25, align 4, !tbaa !5
  %27 = icmp sgt i32 %26, -3
  br i1 %27, label %28, label %62, !llvm.loop !34

28:                                               ; preds = %8, %22
  %29 = phi i32 [ %20, %22 ], [ 1, %8 ]
  %30 = phi i32 [ %31, %22 ], [ 1, %8 ]
  %31 = add nuw nsw i32 %30, 1
  %32 = mul nsw i32 %31, 3
  %33 = and i32 %32, 15
  %34 = zext i32 %33 to i64
  %35 = getelementptr inbounds i32, ptr %0, i64 %34
  %36 = load i32, ptr %35, align 4, !tbaa !5
  %37 = xor i32 %30, -1
  %38 = add i32 %10, %37
  %39 = and i32 %31, 15
  %40 = zext i32 %39 to i64
  %41 = getelementptr inbounds i32, ptr %0, i64 %40
  store i32 %38, ptr %41, align 4, !tbaa !5
  br i1 %12, label %42, label %19

42:                                               ; preds = %28
  %43 = add nuw nsw i32 %30, 3
  %44 = and i32 %43, 15
  %45 = zext i32 %44 to i64
  %46 = getelementptr inbounds i32, ptr %1, i64 %45
  br label %47

47:                                               ; preds = %42, %52
  %48 = phi i32 [ %11, %42 ], [ %53, %52 ]
  br i1 %14, label %49, label %52

49:                                               ; preds = %47
  %50 = load i32, ptr %15, align 4, !tbaa !5
  br label %55

51:                                               ; preds = %55
  store i32 %59, ptr %15, align 4, !tbaa !5
  store i32 1, ptr %46, align 4, !tbaa !5
  br label %52

52:                                               ; preds = %51, %47
  %53 = add nsw i32 %48, 1
  %54 = icmp slt i32 %48, 12
  br i1 %54, label %47, label %19, !llvm.loop !35

55:                                               ; preds = %49, %55
  %56 = phi i32 [ %50, %49 ], [ %59, %55 ]
  %57 = phi i32 [ 1, %49 ], [ %60, %55 ]
  %58 = shl i32 %57, 7
  %59 = xor i32 %56, %58
  %60 = add nuw nsw i32 %57, 2
  %61 = icmp slt i32 %60, %13
  br i1 %61, label %55, label %51, !llvm.loop !36

62:                                               ; preds = %22, %19
  %63 = xor i32 %36, -2
  br label %64

64:                                               ; preds = %62, %8, %6
  %65 = phi i32 [ %4, %6 ], [ %4, %8 ], [ %63, %62 ]
  %66 = getelementptr inbounds i32, ptr %0, i64 3
  %67 = load i32, ptr %66, align 4, !tbaa !5
  %68 = icmp sgt i32 %4, 0
  br i1 %68, label %69, label %72

69:                                               ; preds = %64
  %70 = getelementptr inbounds float, ptr %3, i64 2
  %71 = load i32, ptr %0, align 4, !tbaa !5
  br label %76

72:                                               ; preds = %93, %64
  %73 = phi i32 [ %67, %64 ], [ %95, %93 ]
  %74 = xor i32 %65, %73
  %75 = xor i32 %74, 7
  ret i32 %75

76:                                               ; preds = %69, %93
  %77 = phi i32 [ 0, %69 ], [ %111, %93 ]
  %78 = phi i32 [ %67, %69 ], [ %95, %93 ]
  %79 = and i32 %77, 15
  %80 = zext i32 %79 to i64
  %81 = getelementptr inbounds i32, ptr %1, i64 %80
  %82 = load i32, ptr %81, align 4, !tbaa !5
  %83 = icmp eq i32 %82, %65
  br i1 %83, label %84, label %93

84:                                               ; preds = %76
  %85 = lshr i32 %78, 6
  %86 = and i32 %85, 15
  %87 = zext i32 %86 to i64
  %88 = getelementptr inbounds float, ptr %3, i64 %87
  %89 = load float, ptr %88, align 4, !tbaa !9
  %90 = load float, ptr %70, align 4, !tbaa !9
  %91 = fsub float %89, %90
  %92 = getelementptr inbounds float, ptr %3, i64 %80
  store float %91, ptr %92, align 4, !tbaa !9
  br label %93

93:                                               ; preds = %84, %76
  %94 = mul i32 %78, %65
  %95 = and i32 %71, %94
  %96 = add nuw nsw i32 %77, 3
  %97 = and i32 %96, 15
  %98 = zext i32 %97 to i64
  %99 = getelementptr inbounds i32, ptr %1, i64 %98
  %100 = load i32, ptr %99, align 4, !tbaa !5
  %101 = and i32 %100, 15
  %102 = zext i32 %101 to i64
  %103 = getelementptr inbounds i32, ptr %0, i64 %102
  %104 = load i32, ptr %103, align 4, !tbaa !5
  %105 = add nuw i32 %77, 14
  %106 = and i32 %105, 15
  %107 = zext i32 %106 to i64
  %108 = getelementptr inbounds i32, ptr %2, i64 %107
  %109 = load i32, ptr %108, align 4, !tbaa !5
  %110 = xor i32 %109, %104
  store i32 %110, ptr %108, align 4, !tbaa !5
  %111 = add nuw nsw i32 %77, 1
  %112 = icmp eq i32 %111, %4
  br i1 %112, label %72, label %76, !llvm.loop !37
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f9(ptr noalias nocapture noundef %0, ptr noalias nocapture noundef writeonly %1, ptr noalias nocapture noundef readonly %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = icmp slt i32 %5, 10
  br i1 %7, label %8, label %12

8:                                                ; preds = %6
  %9 = add nsw i32 %5, -2
  %10 = getelementptr inbounds float, ptr %3, i64 1
  %11 = getelementptr inbounds float, ptr %3, i64 2
  br label %30

12:                                               ; preds = %30, %6
  %13 = load i32, ptr %0, align 4, !tbaa !5
  %14 = ashr i32 %13, 2
  %15 = getelementptr inbounds float, ptr %3, i64 6
  %16 = load float, ptr %15, align 4, !tbaa !9
  %17 = getelementptr inbounds float, ptr %3, i64 3
  %18 = load float, ptr %17, align 4, !tbaa !9
  %19 = fcmp olt float %16, %18
  %20 = select i1 %19, i32 %5, i32 7
  %21 = ashr i32 %4, 2
  %22 = add i32 %20, %21
  %23 = lshr i32 %14, 15
  %24 = and i32 %23, 15
  %25 = zext i32 %24 to i64
  %26 = getelementptr inbounds i32, ptr %0, i64 %25
  store i32 %22, ptr %26, align 4, !tbaa !5
  %27 = icmp sgt i32 %4, -1
  br i1 %27, label %28, label %53

28:                                               ; preds = %12
  %29 = icmp ugt i32 %4, 1
  br label %41

30:                                               ; preds = %8, %30
  %31 = phi i32 [ %9, %8 ], [ %39, %30 ]
  %32 = load float, ptr %10, align 4, !tbaa !9
  %33 = load float, ptr %11, align 4, !tbaa !9
  %34 = fadd float %32, %33
  %35 = mul nsw i32 %31, 3
  %36 = and i32 %35, 15
  %37 = zext i32 %36 to i64
  %38 = getelementptr inbounds float, ptr %3, i64 %37
  store float %34, ptr %38, align 4, !tbaa !9
  %39 = add nsw i32 %31, 1
  %40 = icmp slt i32 %31, 7
  br i1 %40, label %30, label %12, !llvm.loop !38

41:                                               ; preds = %28, %57
  %42 = phi i32 [ %4, %28 ], [ %59, %57 ]
  %43 = phi i32 [ %4, %28 ], [ %58, %57 ]
  br i1 %29, label %44, label %57

44:                                               ; preds = %41
  %45 = mul nsw i32 %42, 3
  %46 = and i32 %45, 15
  %47 = zext i32 %46 to i64
  %48 = getelementptr inbounds i32, ptr %2, i64 %47
  %49 = load i32, ptr %48, align 4, !tbaa !5
  %50 = and i32 %42, 15
  %51 = zext i32 %50 to i64
  %52 = getelementptr inbounds i32, ptr %1, i64 %51
  store i32 %49, ptr %52, align 4, !tbaa !5
  br label %57

53:                                               ; preds = %57, %12
  %54 = phi i32 [ %4, %12 ], [ %58, %57 ]
  %55 = xor i32 %14, %54
  %56 = xor i32 %55, 7
  ret i32 %56

57:                                               ; preds = %44, %41
  %58 = phi i32 [ %43, %41 ], [ %42, %44 ]
  %59 = add nsw i32 %42, -1
  %60 = icmp sgt i32 %42, 0
  br i1 %60, label %41, label %53, !llvm.loop !39
}

; Function Attrs: nofree norecurse nosync nounwind memory(read, argmem: readwrite, inaccessiblemem: none) uwtable
define dso_local i32 @f10(ptr noalias noundef readonly %0, ptr noalias nocapture noundef %1, ptr noalias nocapture noundef readnone %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #0 {
  br label %11

7:                                                ; preds = %23
  %8 = sext i32 %4 to i64
  %9 = getelementptr inbounds i32, ptr %0, i64 %8
  %10 = icmp sgt i32 %4, 0
  br i1 %10, label %27, label %26

11:                                               ; preds = %6, %23
  %12 = phi i64 [ 0, %6 ], [ %24, %23 ]
  %13 = getelementptr inbounds float, ptr %3, i64 %12
  %14 = load float, ptr %13, align 4, !tbaa !9
  %15 = fcmp ogt float %14, 1.000000e+00
  br i1 %15, label %16, label %23

16:                                               ; preds = %11
  %17 = getelementptr inbounds i32, ptr %0, i64 %12
  %18 = load i32, ptr %17, align 4, !tbaa !5
  %19 = ashr i32 %18, 15
  %20 = add nuw i64 %12, 15
  %21 = and i64 %20, 15
  %22 = getelementptr inbounds i32, ptr %1, i64 %21
  store i32 %19, ptr %22, align 4, !tbaa !5
  br label %23

23:                                               ; preds = %11, %16
  %24 = add nuw nsw i64 %12, 1
  %25 = icmp eq i64 %24, 9
  br i1 %25, label %7, label %11, !llvm.loop !40

26:                                               ; preds = %27, %7
  ret i32 7

27:                                               ; preds = %7, %27
  %28 = phi ptr [ %35, %27 ], [ %0, %7 ]
  %29 = load i32, ptr %28, align 4, !tbaa !5
  %30 = and i32 %29, 15
  %31 = zext i32 %30 to i64
  %32 = getelementptr inbounds float, ptr %3, i64 %31
  %33 = load float, ptr %32, align 4, !tbaa !9
  %34 = fadd float %33, 1.250000e+00
  store float %34, ptr %32, align 4, !tbaa !9
  %35 = getelementptr inbounds i32, ptr %28, i64 1
  %36 = icmp ult ptr %35, %9
  br i1 %36, label %27, label %26, !llvm.loop !41
}

; Function Attrs: nofree norecurse nosync nounwind memory(read, argmem: readwrite, inaccessiblemem: none) uwtable
define dso_local i32 @f11(ptr noalias noundef %0, ptr noalias nocapture noundef writeonly %1, ptr noalias nocapture noundef %2, ptr noalias nocapture noundef readonly %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #0 {
  %7 = sext i32 %4 to i64
  %8 = getelementptr inbounds i32, ptr %0, i64 %7
  %9 = icmp eq i32 %4, 0
  br i1 %9, label %16, label %30

10:                                               ; preds = %30
  %11 = and i32 %5, 9
  %12 = zext i32 %11 to i64
  %13 = getelementptr inbounds i32, ptr %0, i64 %12
  %14 = load i32, ptr %13, align 4, !tbaa !5
  %15 = xor i32 %14, 7
  br label %16

16:                                               ; preds = %10, %6
  %17 = phi i32 [ %15, %10 ], [ 1, %6 ]
  %18 = getelementptr inbounds i32, ptr %2, i64 6
  %19 = load i32, ptr %18, align 4, !tbaa !5
  %20 = and i32 %19, 15
  %21 = zext i32 %20 to i64
  %22 = getelementptr inbounds i32, ptr %0, i64 %21
  %23 = load i32, ptr %22, align 4, !tbaa !5
  %24 = getelementptr inbounds i32, ptr %0, i64 12
  store i32 %23, ptr %24, align 4, !tbaa !5
  %25 = getelementptr inbounds float, ptr %3, i64 1
  %26 = load float, ptr %25, align 4, !tbaa !9
  %27 = getelementptr inbounds float, ptr %3, i64 3
  %28 = load float, ptr %27, align 4, !tbaa !9
  %29 = fcmp oeq float %26, %28
  br i1 %29, label %49, label %41

30:                                               ; preds = %6, %30
  %31 = phi ptr [ %39, %30 ], [ %0, %6 ]
  %32 = load i32, ptr %31, align 4, !tbaa !5
  %33 = add i32 %32, %5
  %34 = xor i32 %33, 7
  %35 = mul nsw i32 %32, 3
  %36 = and i32 %35, 15
  %37 = zext i32 %36 to i64
  %38 = getelementptr inbounds i32, ptr %0, i64 %37
  store i32 %34, ptr %38, align 4, !tbaa !5
  %39 = getelementptr inbounds i32, ptr %31, i64 1
  %40 = icmp eq ptr %39, %8
  br i1 %40, label %10, label %30, !llvm.loop !42

41:                                               ; preds = %16
  %42 = getelementptr inbounds float, ptr %3, i64 6
  %43 = load float, ptr %42, align 4, !tbaa !9
  %44 = fcmp ugt float %43, 1.000000e+00
  br i1 %44, label %45, label %49

45:                                               ; preds = %41
  %46 = icmp sgt i32 %5, 2
  %47 = xor i32 %5, 7
  %48 = sub i32 7, %17
  br label %52

49:                                               ; preds = %41, %16
  %50 = getelementptr inbounds i32, ptr %0, i64 4
  %51 = load i32, ptr %50, align 4, !tbaa !5
  br label %82

52:                                               ; preds = %45, %66
  %53 = phi i64 [ 1, %45 ], [ %70, %66 ]
  br i1 %46, label %54, label %66

54:                                               ; preds = %52
  %55 = add nuw nsw i64 %53, 3
  %56 = icmp eq i64 %53, 7
  %57 = select i1 %56, i32 %48, i32 0
  br label %72

58:                                               ; preds = %66
  %59 = xor i32 %17, %4
  %60 = xor i32 %59, 7
  br label %82

61:                                               ; preds = %72
  %62 = getelementptr inbounds i32, ptr %0, i64 %55
  %63 = getelementptr inbounds i32, ptr %1, i64 %53
  %64 = and i32 %73, %17
  %65 = lshr i32 %64, 25
  store i32 %65, ptr %62, align 4, !tbaa !5
  store i32 %4, ptr %63, align 4, !tbaa !5
  br label %66

66:                                               ; preds = %61, %52
  %67 = add nuw nsw i64 %53, 14
  %68 = and i64 %67, 15
  %69 = getelementptr inbounds i32, ptr %1, i64 %68
  store i32 %47, ptr %69, align 4, !tbaa !5
  %70 = add nuw nsw i64 %53, 1
  %71 = icmp eq i64 %70, 13
  br i1 %71, label %58, label %52, !llvm.loop !43

72:                                               ; preds = %54, %72
  %73 = phi i32 [ 2, %54 ], [ %80, %72 ]
  %74 = add i32 %73, %4
  %75 = and i32 %74, 15
  %76 = zext i32 %75 to i64
  %77 = getelementptr inbounds i32, ptr %2, i64 %76
  %78 = load i32, ptr %77, align 4, !tbaa !5
  %79 = xor i32 %78, %57
  store i32 %79, ptr %77, align 4, !tbaa !5
  %80 = add nuw nsw i32 %73, 1
  %81 = icmp eq i32 %80, %5
  br i1 %81, label %61, label %72, !llvm.loop !44

82:                                               ; preds = %58, %49
  %83 = phi i32 [ %51, %49 ], [ %60, %58 ]
  ret i32 %83
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f12(ptr noalias nocapture noundef %0, ptr noalias nocapture noundef writeonly %1, ptr noalias nocapture noundef readnone %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = icmp eq i32 %4, 0
  br i1 %7, label %16, label %8

8:                                                ; preds = %6
  %9 = getelementptr inbounds i32, ptr %0, i64 4
  %10 = add nsw i32 %5, -2
  %11 = sext i32 %10 to i64
  %12 = and i32 %4, 7
  %13 = zext i32 %12 to i64
  %14 = icmp slt i32 %10, %12
  %15 = icmp eq i32 %12, 0
  br label %22

16:                                               ; preds = %32, %6
  %17 = phi i32 [ 1, %6 ], [ %33, %32 ]
  %18 = getelementptr inbounds i32, ptr %0, i64 7
  %19 = load i32, ptr %18, align 4, !tbaa !5
  %20 = getelementptr inbounds i32, ptr %1, i64 10
  store i32 %19, ptr %20, align 4, !tbaa !5
  %21 = xor i32 %17, -7
  ret i32 %21

22:                                               ; preds = %8, %32
  %23 = phi i32 [ 0, %8 ], [ %34, %32 ]
  %24 = phi i32 [ 1, %8 ], [ %33, %32 ]
  %25 = load i32, ptr %9, align 4, !tbaa !5
  %26 = mul nuw nsw i32 %23, 3
  %27 = and i32 %26, 15
  %28 = zext i32 %27 to i64
  %29 = getelementptr inbounds i32, ptr %1, i64 %28
  store i32 %25, ptr %29, align 4, !tbaa !5
  br i1 %14, label %30, label %32

30:                                               ; preds = %22
  %31 = xor i32 %23, -7
  br label %36

32:                                               ; preds = %49, %22
  %33 = phi i32 [ %24, %22 ], [ %40, %49 ]
  %34 = add nuw nsw i32 %23, 1
  %35 = icmp eq i32 %34, %4
  br i1 %35, label %16, label %22, !llvm.loop !45

36:                                               ; preds = %30, %49
  %37 = phi i64 [ %11, %30 ], [ %50, %49 ]
  %38 = trunc i64 %37 to i32
  %39 = xor i32 %38, 6
  %40 = or i32 %39, %31
  br i1 %15, label %49, label %41

41:                                               ; preds = %36
  %42 = add i32 %40, %5
  %43 = mul i64 %37, 3
  %44 = and i64 %43, 15
  %45 = getelementptr inbounds float, ptr %3, i64 %44
  br label %52

46:                                               ; preds = %52
  %47 = ashr i32 %42, 2
  %48 = getelementptr inbounds i32, ptr %0, i64 %44
  store i32 %47, ptr %48, align 4, !tbaa !5
  br label %49

49:                                               ; preds = %46, %36
  %50 = add nsw i64 %37, 2
  %51 = icmp slt i64 %50, %13
  br i1 %51, label %36, label %32, !llvm.loop !46

52:                                               ; preds = %41, %52
  %53 = phi i32 [ 1, %41 ], [ %60, %52 ]
  %54 = load float, ptr %45, align 4, !tbaa !9
  %55 = fadd float %54, -5.000000e-01
  %56 = lshr i32 %53, 2
  %57 = and i32 %56, 15
  %58 = zext i32 %57 to i64
  %59 = getelementptr inbounds float, ptr %3, i64 %58
  store float %55, ptr %59, align 4, !tbaa !9
  %60 = add nuw nsw i32 %53, 2
  %61 = icmp ugt i32 %60, %12
  br i1 %61, label %46, label %52, !llvm.loop !47
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f13(ptr noalias nocapture noundef %0, ptr noalias nocapture noundef writeonly %1, ptr noalias nocapture noundef %2, ptr noalias nocapture noundef readonly %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = icmp eq i32 %4, 0
  br i1 %7, label %30, label %8

8:                                                ; preds = %6
  %9 = getelementptr inbounds i32, ptr %2, i64 7
  %10 = load i32, ptr %9, align 4, !tbaa !5
  %11 = getelementptr inbounds i32, ptr %0, i64 5
  %12 = icmp ne i32 %4, -268435456
  br label %13

13:                                               ; preds = %13, %8
  %14 = phi i32 [ 0, %8 ], [ %27, %13 ]
  %15 = add i32 %10, %14
  store i32 %15, ptr %11, align 4, !tbaa !5
  %16 = and i32 %14, 15
  %17 = zext i32 %16 to i64
  %18 = getelementptr inbounds i32, ptr %0, i64 %17
  %19 = load i32, ptr %18, align 4, !tbaa !5
  %20 = and i32 %19, 15
  %21 = zext i32 %20 to i64
  %22 = getelementptr inbounds i32, ptr %2, i64 %21
  %23 = load i32, ptr %22, align 4, !tbaa !5
  %24 = sub i32 %23, %4
  %25 = icmp ugt i32 %24, %5
  %26 = and i1 %12, %25
  %27 = add nuw nsw i32 %14, 1
  %28 = icmp eq i32 %27, %4
  %29 = select i1 %26, i1 true, i1 %28
  br i1 %29, label %30, label %13, !llvm.loop !48

30:                                               ; preds = %13, %6
  %31 = phi i32 [ 1, %6 ], [ %23, %13 ]
  %32 = and i32 %31, %5
  %33 = icmp slt i32 %32, %5
  %34 = getelementptr inbounds float, ptr %3, i64 11
  %35 = load float, ptr %34, align 4, !tbaa !9
  %36 = getelementptr inbounds float, ptr %3, i64 3
  %37 = load float, ptr %36, align 4, !tbaa !9
  %38 = fcmp olt float %35, %37
  %39 = srem i32 %4, 2
  %40 = select i1 %38, i32 %39, i32 %4
  %41 = add i32 %4, -1
  %42 = getelementptr inbounds i32, ptr %0, i64 13
  %43 = tail call i32 @llvm.smax.i32(i32 %41, i32 1)
  br label %44

44:                                               ; preds = %51, %30
  %45 = phi i32 [ 0, %30 ], [ %55, %51 ]
  br i1 %33, label %46, label %51

46:                                               ; preds = %44
  %47 = mul nsw i32 %45, 3
  %48 = and i32 %47, 15
  %49 = zext i32 %48 to i64
  %50 = getelementptr inbounds i32, ptr %1, i64 %49
  store i32 7, ptr %50, align 4, !tbaa !5
  store i32 %4, ptr %42, align 4, !tbaa !5
  br label %51

51:                                               ; preds = %44, %46
  %52 = and i32 %45, 15
  %53 = zext i32 %52 to i64
  %54 = getelementptr inbounds i32, ptr %2, i64 %53
  store i32 %40, ptr %54, align 4, !tbaa !5
  %55 = add nuw nsw i32 %45, 1
  %56 = icmp eq i32 %55, %43
  br i1 %56, label %57, label %44, !llvm.loop !49

57:                                               ; preds = %51
  %58 = getelementptr inbounds i32, ptr %2, i64 15
  %59 = load i32, ptr %58, align 4, !tbaa !5
  %60 = xor i32 %59, 7
  store i32 %60, ptr %58, align 4, !tbaa !5
  %61 = xor i32 %31, %4
  %62 = xor i32 %61, 7
  ret i32 %62
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f14(ptr noalias nocapture noundef writeonly %0, ptr noalias nocapture noundef %1, ptr noalias nocapture noundef readonly %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = add nsw i32 %5, -2
  %8 = add i32 %4, -1
  br label %9

9:                                                ; preds = %16, %6
  %10 = phi i32 [ %7, %6 ], [ %21, %16 ]
  %11 = and i32 %10, 15
  %12 = zext i32 %11 to i64
  %13 = getelementptr inbounds float, ptr %3, i64 %12
  %14 = load float, ptr %13, align 4, !tbaa !9
  %15 = fcmp oeq float %14, 5.000000e-01
  br i1 %15, label %23, label %16

16:                                               ; preds = %9
  %17 = mul nsw i32 %10, 3
  %18 = and i32 %17, 15
  %19 = zext i32 %18 to i64
  %20 = getelementptr inbounds i32, ptr %1, i64 %19
  store i32 %8, ptr %20, align 4, !tbaa !5
  %21 = add nsw i32 %10, 1
  %22 = icmp slt i32 %21, %4
  br i1 %22, label %9, label %23, !llvm.loop !50

23:                                               ; preds = %9, %16
  %24 = getelementptr inbounds float, ptr %3, i64 12
  %25 = load float, ptr %24, align 4, !tbaa !9
  %26 = getelementptr inbounds float, ptr %3, i64 3
  %27 = load float, ptr %26, align 4, !tbaa !9
  %28 = fcmp oeq float %25, %27
  br i1 %28, label %29, label %43

29:                                               ; preds = %23
  %30 = load float, ptr %3, align 4, !tbaa !9
  %31 = fcmp ogt float %30, 1.000000e+00
  br i1 %31, label %32, label %43

32:                                               ; preds = %29
  %33 = getelementptr inbounds i32, ptr %1, i64 7
  %34 = load i32, ptr %33, align 4, !tbaa !5
  %35 = and i32 %4, 15
  %36 = and i32 %35, %5
  %37 = zext i32 %36 to i64
  %38 = getelementptr inbounds i32, ptr %2, i64 %37
  %39 = load i32, ptr %38, align 4, !tbaa !5
  %40 = and i32 %39, 15
  %41 = zext i32 %40 to i64
  %42 = getelementptr inbounds i32, ptr %1, i64 %41
  store i32 %34, ptr %42, align 4, !tbaa !5
  br label %43

43:                                               ; preds = %32, %29, %23
  %44 = getelementptr inbounds float, ptr %3, i64 9
  %45 = load float, ptr %44, align 4, !tbaa !9
  %46 = fmul float %45, 1.250000e+00
  %47 = getelementptr inbounds float, ptr %3, i64 11
  store float %46, ptr %47, align 4, !tbaa !9
  %48 = icmp slt i32 %5, 0
  br i1 %48, label %49, label %51

49:                                               ; preds = %51, %43
  %50 = xor i32 %4, 6
  ret i32 %50

51:                                               ; preds = %43, %51
  %52 = phi i32 [ %65, %51 ], [ 0, %43 ]
  %53 = mul nuw nsw i32 %52, 3
  %54 = and i32 %53, 15
  %55 = zext i32 %54 to i64
  %56 = getelementptr inbounds i32, ptr %1, i64 %55
  %57 = load i32, ptr %56, align 4, !tbaa !5
  %58 = and i32 %52, 15
  %59 = zext i32 %58 to i64
  %60 = getelementptr inbounds i32, ptr %0, i64 %59
  store i32 %57, ptr %60, align 4, !tbaa !5
  %61 = add nuw i32 %52, 14
  %62 = and i32 %61, 15
  %63 = zext i32 %62 to i64
  %64 = getelementptr inbounds i32, ptr %1, i64 %63
  store i32 -1, ptr %64, align 4, !tbaa !5
  %65 = add nuw i32 %52, 1
  %66 = icmp eq i32 %52, %5
  br i1 %66, label %49, label %51, !llvm.loop !51
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f15(ptr noalias noundef readonly %0, ptr noalias nocapture noundef writeonly %1, ptr noalias nocapture noundef readonly %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = icmp sgt i32 %5, 0
  br i1 %7, label %8, label %23

8:                                                ; preds = %6
  %9 = sext i32 %4 to i64
  %10 = getelementptr inbounds i32, ptr %0, i64 %9
  %11 = icmp sgt i32 %4, 0
  %12 = getelementptr inbounds i32, ptr %2, i64 13
  br label %13

13:                                               ; preds = %8, %33
  %14 = phi i32 [ %5, %8 ], [ %35, %33 ]
  %15 = phi i32 [ %4, %8 ], [ %34, %33 ]
  br i1 %11, label %16, label %33

16:                                               ; preds = %13
  %17 = add i32 %14, 15
  %18 = and i32 %17, 15
  %19 = zext i32 %18 to i64
  %20 = getelementptr inbounds float, ptr %3, i64 %19
  %21 = load float, ptr %20, align 4, !tbaa !9
  %22 = fcmp ogt float %21, 1.000000e+00
  br label %37

23:                                               ; preds = %33, %6
  %24 = phi i32 [ %4, %6 ], [ %34, %33 ]
  %25 = xor i32 %4, 1
  %26 = add i32 %24, %25
  %27 = icmp ugt i32 %4, 1
  br i1 %27, label %28, label %46

28:                                               ; preds = %23
  %29 = and i32 %24, 255
  %30 = sitofp i32 %29 to float
  %31 = shl i32 %24, 28
  %32 = and i32 %31, %4
  br label %50

33:                                               ; preds = %42, %13
  %34 = phi i32 [ %15, %13 ], [ %43, %42 ]
  %35 = add nsw i32 %14, -1
  %36 = icmp sgt i32 %14, 1
  br i1 %36, label %13, label %23, !llvm.loop !52

37:                                               ; preds = %16, %42
  %38 = phi ptr [ %0, %16 ], [ %44, %42 ]
  %39 = phi i32 [ %15, %16 ], [ %43, %42 ]
  br i1 %22, label %42, label %40

40:                                               ; preds = %37
  %41 = load i32, ptr %12, align 4, !tbaa !5
  br label %42

42:                                               ; preds = %40, %37
  %43 = phi i32 [ %39, %37 ], [ %41, %40 ]
  %44 = getelementptr inbounds i32, ptr %38, i64 1
  %45 = icmp ult ptr %44, %10
  br i1 %45, label %37, label %33, !llvm.loop !53

46:                                               ; preds = %50, %23
  %47 = phi i32 [ %26, %23 ], [ %58, %50 ]
  %48 = xor i32 %24, %47
  %49 = xor i32 %48, 7
  ret i32 %49

50:                                               ; preds = %28, %50
  %51 = phi i32 [ 1, %28 ], [ %73, %50 ]
  %52 = phi i32 [ %26, %28 ], [ %58, %50 ]
  %53 = add nsw i32 %51, 3
  %54 = and i32 %53, 15
  %55 = zext i32 %54 to i64
  %56 = getelementptr inbounds i32, ptr %0, i64 %55
  %57 = load i32, ptr %56, align 4, !tbaa !5
  %58 = xor i32 %57, %52
  %59 = getelementptr inbounds float, ptr %3, i64 %55
  %60 = load float, ptr %59, align 4, !tbaa !9
  %61 = fmul float %60, %30
  %62 = add i32 %51, 14
  %63 = and i32 %62, 15
  %64 = zext i32 %63 to i64
  %65 = getelementptr inbounds float, ptr %3, i64 %64
  store float %61, ptr %65, align 4, !tbaa !9
  %66 = and i32 %51, 15
  %67 = zext i32 %66 to i64
  %68 = getelementptr inbounds i32, ptr %0, i64 %67
  %69 = load i32, ptr %68, align 4, !tbaa !5
  %70 = and i32 %69, 15
  %71 = zext i32 %70 to i64
  %72 = getelementptr inbounds i32, ptr %1, i64 %71
  store i32 %32, ptr %72, align 4, !tbaa !5
  %73 = add nuw i32 %51, 1
  %74 = icmp eq i32 %73, %4
  br i1 %74, label %46, label %50, !llvm.loop !54
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f16(ptr noalias nocapture noundef %0, ptr noalias nocapture noundef %1, ptr noalias nocapture noundef readnone %2, ptr noalias nocapture noundef readnone %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = add nsw i32 %4, -1
  %8 = icmp sgt i32 %4, 3
  br i1 %8, label %9, label %17

9:                                                ; preds = %6
  %10 = tail call i32 @llvm.smax.i32(i32 %7, i32 3)
  %11 = zext i32 %10 to i64
  %12 = mul nuw nsw i64 %11, 3
  %13 = add nuw nsw i64 %12, 13
  %14 = and i64 %13, 15
  %15 = getelementptr inbounds i32, ptr %0, i64 %14
  %16 = load i32, ptr %15, align 4, !tbaa !5
  br label %17

17:                                               ; preds = %9, %6
  %18 = phi i32 [ %16, %9 ], [ %4, %6 ]
  %19 = load i32, ptr %0, align 4, !tbaa !5
  %20 = getelementptr inbounds i32, ptr %1, i64 7
  store i32 %19, ptr %20, align 4, !tbaa !5
  %21 = add i32 %5, 7
  %22 = icmp slt i32 %21, 2
  br i1 %22, label %23, label %96

23:                                               ; preds = %17
  %24 = and i32 %4, 6
  %25 = xor i32 %24, 2
  %26 = getelementptr inbounds i32, ptr %1, i64 2
  %27 = icmp slt i32 %4, 1
  br i1 %27, label %92, label %28

28:                                               ; preds = %23
  %29 = getelementptr inbounds i32, ptr %0, i64 3
  %30 = getelementptr inbounds i32, ptr %0, i64 7
  %31 = mul i32 %4, %4
  %32 = and i32 %31, 13
  %33 = zext i32 %32 to i64
  %34 = getelementptr inbounds i32, ptr %0, i64 %33
  %35 = shl i32 %4, 27
  %36 = getelementptr inbounds i32, ptr %1, i64 1
  %37 = add nsw i32 %5, -2
  br label %38

38:                                               ; preds = %28, %89
  %39 = phi i1 [ %27, %28 ], [ %91, %89 ]
  %40 = phi i32 [ %7, %28 ], [ %90, %89 ]
  %41 = phi i32 [ undef, %28 ], [ %87, %89 ]
  %42 = phi i32 [ %18, %28 ], [ %57, %89 ]
  %43 = add i32 %42, -6
  %44 = load i32, ptr %29, align 4, !tbaa !5
  %45 = icmp slt i32 %43, %44
  br i1 %45, label %46, label %48

46:                                               ; preds = %38
  store i32 -9, ptr %34, align 4, !tbaa !5
  %47 = mul i32 %35, %42
  store i32 %47, ptr %36, align 4, !tbaa !5
  br label %56

48:                                               ; preds = %38
  %49 = load i32, ptr %26, align 4, !tbaa !5
  %50 = and i32 %49, 15
  %51 = zext i32 %50 to i64
  %52 = getelementptr inbounds i32, ptr %1, i64 %51
  store i32 %25, ptr %52, align 4, !tbaa !5
  %53 = add i32 %40, %42
  %54 = load i32, ptr %30, align 4, !tbaa !5
  %55 = icmp slt i32 %53, %54
  br i1 %55, label %56, label %92

56:                                               ; preds = %48, %46
  %57 = phi i32 [ 7, %46 ], [ %42, %48 ]
  %58 = and i32 %40, 15
  %59 = zext i32 %58 to i64
  %60 = getelementptr inbounds i32, ptr %1, i64 %59
  %61 = load i32, ptr %60, align 4, !tbaa !5
  br label %62

62:                                               ; preds = %83, %56
  %63 = phi i32 [ %41, %56 ], [ %81, %83 ]
  %64 = phi i32 [ %37, %56 ], [ %84, %83 ]
  %65 = and i32 %64, 15
  %66 = zext i32 %65 to i64
  %67 = getelementptr inbounds i32, ptr %0, i64 %66
  store i32 %57, ptr %67, align 4, !tbaa !5
  %68 = sub i32 %64, %57
  %69 = icmp slt i32 %61, %68
  br i1 %69, label %86, label %70

70:                                               ; preds = %62
  %71 = icmp slt i32 %64, %4
  %72 = select i1 %71, i32 %5, i32 %4
  %73 = icmp ult i32 %57, %72
  br label %77

74:                                               ; preds = %77
  %75 = add nuw nsw i64 %78, 3
  %76 = icmp ugt i64 %78, 3
  br i1 %76, label %79, label %77, !llvm.loop !55

77:                                               ; preds = %70, %74
  %78 = phi i64 [ 1, %70 ], [ %75, %74 ]
  br i1 %73, label %79, label %74

79:                                               ; preds = %77, %74
  %80 = phi i1 [ false, %77 ], [ %76, %74 ]
  %81 = phi i32 [ %61, %77 ], [ %63, %74 ]
  %82 = phi i32 [ 1, %77 ], [ 10, %74 ]
  br i1 %80, label %83, label %86

83:                                               ; preds = %79
  %84 = add nsw i32 %64, 1
  %85 = icmp slt i32 %84, %5
  br i1 %85, label %62, label %86, !llvm.loop !56

86:                                               ; preds = %79, %83, %62
  %87 = phi i32 [ %63, %62 ], [ %81, %83 ], [ %81, %79 ]
  %88 = phi i32 [ 0, %62 ], [ 0, %83 ], [ %82, %79 ]
  switch i32 %88, label %92 [
    i32 0, label %89
    i32 7, label %89
  ]

89:                                               ; preds = %86, %86
  %90 = add nsw i32 %40, -3
  %91 = icmp slt i32 %40, 3
  br i1 %91, label %92, label %38, !llvm.loop !57

92:                                               ; preds = %86, %89, %48, %23
  %93 = phi i1 [ %27, %23 ], [ %39, %86 ], [ %91, %89 ], [ %39, %48 ]
  %94 = phi i32 [ %18, %23 ], [ %57, %86 ], [ %57, %89 ], [ %42, %48 ]
  %95 = phi i32 [ undef, %23 ], [ %87, %86 ], [ %87, %89 ], [ 8, %48 ]
  br i1 %93, label %96, label %99

96:                                               ; preds = %92, %17
  %97 = phi i32 [ %94, %92 ], [ %18, %17 ]
  %98 = xor i32 %97, 6
  br label %99

99:                                               ; preds = %92, %96
  %100 = phi i32 [ %98, %96 ], [ %95, %92 ]
  ret i32 %100
}

; Function Attrs: nofree norecurse nosync nounwind memory(read, argmem: readwrite, inaccessiblemem: none) uwtable
define dso_local i32 @f17(ptr noalias noundef %0, ptr noalias noundef writeonly %1, ptr noalias nocapture noundef readnone %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #0 {
  %7 = sext i32 %4 to i64
  %8 = getelementptr inbounds i32, ptr %0, i64 %7
  %9 = icmp sgt i32 %4, 0
  br i1 %9, label %10, label %47

10:                                               ; preds = %6
  %11 = getelementptr inbounds i32, ptr %1, i64 %7
  %12 = getelementptr inbounds float, ptr %3, i64 2
  %13 = add i32 %4, 7
  %14 = and i32 %13, 15
  %15 = zext i32 %14 to i64
  %16 = getelementptr inbounds float, ptr %3, i64 %15
  br label %17

17:                                               ; preds = %10, %21
  %18 = phi ptr [ %0, %10 ], [ %22, %21 ]
  br label %19

19:                                               ; preds = %17, %24
  %20 = phi ptr [ %25, %24 ], [ %1, %17 ]
  br label %27

21:                                               ; preds = %24
  %22 = getelementptr inbounds i32, ptr %18, i64 1
  %23 = icmp ult ptr %22, %8
  br i1 %23, label %17, label %47, !llvm.loop !58

24:                                               ; preds = %27
  %25 = getelementptr inbounds i32, ptr %20, i64 1
  %26 = icmp ult ptr %25, %11
  br i1 %26, label %19, label %21, !llvm.loop !59

27:                                               ; preds = %19, %27
  %28 = phi ptr [ %45, %27 ], [ %0, %19 ]
  %29 = load i32, ptr %18, align 4, !tbaa !5
  %30 = add nsw i32 %29, 2
  %31 = and i32 %30, 15
  %32 = zext i32 %31 to i64
  %33 = getelementptr inbounds i32, ptr %0, i64 %32
  store i32 7, ptr %33, align 4, !tbaa !5
  %34 = load i32, ptr %18, align 4, !tbaa !5
  %35 = and i32 %34, 15
  %36 = zext i32 %35 to i64
  %37 = getelementptr inbounds float, ptr %3, i64 %36
  %38 = load float, ptr %37, align 4, !tbaa !9
  %39 = load float, ptr %12, align 4, !tbaa !9
  %40 = fsub float %38, %39
  store float %40, ptr %16, align 4, !tbaa !9
  %41 = load i32, ptr %28, align 4, !tbaa !5
  %42 = and i32 %41, 15
  %43 = zext i32 %42 to i64
  %44 = getelementptr inbounds i32, ptr %1, i64 %43
  store i32 1, ptr %44, align 4, !tbaa !5
  %45 = getelementptr inbounds i32, ptr %28, i64 1
  %46 = icmp ult ptr %45, %8
  br i1 %46, label %27, label %24, !llvm.loop !60

47:                                               ; preds = %21, %6
  ret i32 5
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f18(ptr noalias nocapture noundef writeonly %0, ptr noalias nocapture noundef %1, ptr noalias nocapture noundef readnone %2, ptr noalias nocapture noundef readonly %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = icmp eq i32 %4, 0
  br i1 %7, label %22, label %8

8:                                                ; preds = %6
  %9 = and i32 %4, 7
  %10 = icmp ugt i32 %9, 2
  br label %11

11:                                               ; preds = %8, %39
  %12 = phi i32 [ 0, %8 ], [ %40, %39 ]
  br i1 %10, label %13, label %39

13:                                               ; preds = %11
  %14 = add nuw nsw i32 %12, 3
  %15 = and i32 %14, 15
  %16 = zext i32 %15 to i64
  %17 = getelementptr inbounds i32, ptr %1, i64 %16
  %18 = load i32, ptr %17, align 4, !tbaa !5
  %19 = and i32 %12, 15
  %20 = zext i32 %19 to i64
  %21 = getelementptr inbounds i32, ptr %0, i64 %20
  store i32 %18, ptr %21, align 4, !tbaa !5
  br label %39

22:                                               ; preds = %39, %6
  %23 = getelementptr inbounds i32, ptr %1, i64 10
  store i32 0, ptr %23, align 4, !tbaa !5
  %24 = and i32 %4, 7
  %25 = zext i32 %24 to i64
  %26 = getelementptr inbounds float, ptr %3, i64 %25
  %27 = load float, ptr %26, align 4, !tbaa !9
  %28 = fcmp ole float %27, 5.000000e-01
  %29 = and i32 %4, 15
  %30 = zext i32 %29 to i64
  %31 = select i1 %28, i64 %30, i64 1
  %32 = getelementptr inbounds i32, ptr %1, i64 %31
  %33 = load i32, ptr %32, align 4, !tbaa !5
  %34 = getelementptr inbounds i32, ptr %0, i64 9
  store i32 %33, ptr %34, align 4, !tbaa !5
  %35 = icmp sgt i32 %5, -1
  br i1 %35, label %36, label %42

36:                                               ; preds = %22
  %37 = ashr i32 %4, 30
  %38 = and i32 %37, 7
  br label %47

39:                                               ; preds = %13, %11
  %40 = add nuw nsw i32 %12, 1
  %41 = icmp eq i32 %40, %4
  br i1 %41, label %22, label %11, !llvm.loop !61

42:                                               ; preds = %58, %22
  %43 = phi i32 [ %4, %22 ], [ %59, %58 ]
  %44 = phi i32 [ 1, %22 ], [ %61, %58 ]
  %45 = xor i32 %43, %44
  %46 = xor i32 %45, 7
  ret i32 %46

47:                                               ; preds = %36, %58
  %48 = phi i32 [ %5, %36 ], [ %62, %58 ]
  %49 = phi i32 [ 1, %36 ], [ %61, %58 ]
  %50 = phi i32 [ %4, %36 ], [ %59, %58 ]
  switch i32 %38, label %58 [
    i32 0, label %51
    i32 1, label %54
  ]

51:                                               ; preds = %47
  %52 = and i32 %48, 1023
  %53 = add nsw i32 %52, %49
  br label %54

54:                                               ; preds = %47, %51
  %55 = phi i32 [ %49, %47 ], [ %53, %51 ]
  %56 = and i32 %48, 1023
  %57 = xor i32 %56, %50
  br label %58

58:                                               ; preds = %47, %54
  %59 = phi i32 [ %50, %47 ], [ %57, %54 ]
  %60 = phi i32 [ %49, %47 ], [ %55, %54 ]
  %61 = xor i32 %60, 5
  %62 = add nsw i32 %48, -1
  %63 = icmp sgt i32 %48, 0
  br i1 %63, label %47, label %42, !llvm.loop !62
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f19(ptr noalias nocapture noundef %0, ptr noalias nocapture noundef %1, ptr noalias nocapture noundef readonly %2, ptr noalias nocapture noundef readonly %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = getelementptr inbounds i32, ptr %1, i64 9
  %8 = lshr i32 %4, 1
  %9 = getelementptr inbounds i32, ptr %2, i64 5
  %10 = load i32, ptr %9, align 4, !tbaa !5
  %11 = and i32 %10, 15
  %12 = zext i32 %11 to i64
  %13 = getelementptr inbounds i32, ptr %1, i64 %12
  %14 = and i32 %4, 7
  %15 = tail call i32 @llvm.umax.i32(i32 %14, i32 1)
  br label %16

16:                                               ; preds = %16, %6
  %17 = phi i32 [ 7, %6 ], [ %20, %16 ]
  %18 = phi i32 [ 0, %6 ], [ %21, %16 ]
  store i32 0, ptr %7, align 4, !tbaa !5
  %19 = mul i32 %17, 5
  %20 = add i32 %19, %8
  store i32 -5, ptr %13, align 4, !tbaa !5
  %21 = add nuw nsw i32 %18, 1
  %22 = icmp eq i32 %21, %15
  br i1 %22, label %23, label %16, !llvm.loop !63

23:                                               ; preds = %16
  %24 = and i32 %5, 15
  %25 = zext i32 %24 to i64
  %26 = getelementptr inbounds i32, ptr %0, i64 %25
  %27 = load i32, ptr %26, align 4, !tbaa !5
  %28 = icmp sgt i32 %27, 8192
  br i1 %28, label %29, label %35

29:                                               ; preds = %23
  %30 = and i32 %20, 15
  %31 = zext i32 %30 to i64
  %32 = getelementptr inbounds i32, ptr %2, i64 %31
  %33 = load i32, ptr %32, align 4, !tbaa !5
  %34 = and i32 %33, %5
  br label %39

35:                                               ; preds = %23
  %36 = getelementptr inbounds i32, ptr %1, i64 2
  %37 = load i32, ptr %36, align 4, !tbaa !5
  %38 = shl i32 %37, 22
  br label %39

39:                                               ; preds = %35, %29
  %40 = phi i32 [ %34, %29 ], [ %38, %35 ]
  %41 = icmp sgt i32 %4, 1
  br i1 %41, label %42, label %51

42:                                               ; preds = %39
  %43 = add i32 %4, -1
  %44 = getelementptr inbounds float, ptr %3, i64 3
  %45 = load float, ptr %44, align 4, !tbaa !9
  %46 = sext i32 %4 to i64
  %47 = sext i32 %43 to i64
  %48 = getelementptr inbounds i32, ptr %0, i64 13
  %49 = sext i32 %43 to i64
  %50 = zext i32 %43 to i64
  br label %56

51:                                               ; preds = %104, %39
  %52 = phi i32 [ 1, %39 ], [ %105, %104 ]
  %53 = phi i32 [ %20, %39 ], [ %106, %104 ]
  %54 = xor i32 %52, %40
  %55 = xor i32 %54, %53
  ret i32 %55

56:                                               ; preds = %42, %104
  %57 = phi i64 [ 0, %42 ], [ %107, %104 ]
  %58 = phi i32 [ %20, %42 ], [ %106, %104 ]
  %59 = phi i32 [ 1, %42 ], [ %105, %104 ]
  %60 = and i64 %57, 15
  %61 = getelementptr inbounds float, ptr %3, i64 %60
  %62 = load float, ptr %61, align 4, !tbaa !9
  %63 = fcmp ogt float %62, %45
  br i1 %63, label %64, label %104

64:                                               ; preds = %56
  %65 = mul i32 %58, %58
  %66 = trunc i64 %57 to i32
  %67 = mul i32 %66, %4
  %68 = add i32 %67, %65
  %69 = add nuw nsw i64 %57, 1
  %70 = icmp slt i64 %69, %49
  %71 = trunc i64 %57 to i32
  br label %72

72:                                               ; preds = %64, %78
  %73 = phi i64 [ 0, %64 ], [ %87, %78 ]
  %74 = phi i32 [ %59, %64 ], [ %79, %78 ]
  br i1 %70, label %75, label %78

75:                                               ; preds = %72
  %76 = and i64 %73, 15
  %77 = getelementptr inbounds i32, ptr %1, i64 %76
  br label %89

78:                                               ; preds = %89, %72
  %79 = phi i32 [ %74, %72 ], [ %101, %89 ]
  %80 = trunc i64 %73 to i32
  %81 = shl i32 %80, 18
  %82 = or i32 %81, %71
  store i32 %82, ptr %48, align 4, !tbaa !5
  %83 = and i64 %73, 15
  %84 = getelementptr inbounds i32, ptr %0, i64 %83
  %85 = load i32, ptr %84, align 4, !tbaa !5
  %86 = getelementptr inbounds i32, ptr %1, i64 %83
  store i32 %85, ptr %86, align 4, !tbaa !5
  %87 = add nuw nsw i64 %73, 1
  %88 = icmp eq i64 %73, %46
  br i1 %88, label %104, label %72, !llvm.loop !64

89:                                               ; preds = %75, %89
  %90 = phi i64 [ %69, %75 ], [ %102, %89 ]
  %91 = phi i32 [ %74, %75 ], [ %101, %89 ]
  %92 = load i32, ptr %77, align 4, !tbaa !5
  %93 = xor i32 %91, %4
  %94 = and i32 %93, 15
  %95 = zext i32 %94 to i64
  %96 = getelementptr inbounds i32, ptr %1, i64 %95
  store i32 %92, ptr %96, align 4, !tbaa !5
  %97 = mul nuw nsw i64 %90, 3
  %98 = and i64 %97, 15
  %99 = getelementptr inbounds i32, ptr %0, i64 %98
  %100 = load i32, ptr %99, align 4, !tbaa !5
  %101 = xor i32 %100, %91
  %102 = add nuw nsw i64 %90, 1
  %103 = icmp slt i64 %102, %47
  br i1 %103, label %89, label %78, !llvm.loop !65

104:                                              ; preds = %78, %56
  %105 = phi i32 [ %59, %56 ], [ %79, %78 ]
  %106 = phi i32 [ %58, %56 ], [ %68, %78 ]
  %107 = add nuw nsw i64 %57, 1
  %108 = and i64 %107, 15
  %109 = getelementptr inbounds i32, ptr %1, i64 %108
  %110 = load i32, ptr %109, align 4, !tbaa !5
  %111 = and i32 %110, %5
  %112 = and i32 %111, %105
  %113 = getelementptr inbounds i32, ptr %1, i64 %60
  store i32 %112, ptr %113, align 4, !tbaa !5
  %114 = icmp eq i64 %107, %50
  br i1 %114, label %51, label %56, !llvm.loop !66
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f20(ptr noalias nocapture noundef writeonly %0, ptr noalias nocapture noundef writeonly %1, ptr noalias nocapture noundef readonly %2, ptr noalias nocapture noundef readnone %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = and i32 %5, 15
  %8 = zext i32 %7 to i64
  %9 = and i32 %4, 7
  %10 = getelementptr inbounds i32, ptr %1, i64 %8
  %11 = zext i32 %9 to i64
  %12 = getelementptr inbounds i32, ptr %2, i64 %11
  %13 = load i32, ptr %12, align 4, !tbaa !5
  store i32 %13, ptr %10, align 4, !tbaa !5
  %14 = shl i32 %4, 1
  %15 = and i32 %14, 14
  %16 = zext i32 %15 to i64
  %17 = getelementptr inbounds i32, ptr %1, i64 %16
  store i32 1, ptr %17, align 4, !tbaa !5
  %18 = srem i32 %4, 2
  %19 = add i32 %4, 1
  %20 = and i32 %19, 15
  %21 = zext i32 %20 to i64
  %22 = getelementptr inbounds i32, ptr %0, i64 %21
  store i32 %18, ptr %22, align 4, !tbaa !5
  %23 = icmp eq i32 %4, 0
  br i1 %23, label %28, label %24

24:                                               ; preds = %6
  %25 = lshr i32 %4, 6
  %26 = lshr i32 %4, 19
  %27 = getelementptr inbounds i32, ptr %0, i64 9
  br label %30

28:                                               ; preds = %41, %6
  %29 = xor i32 %4, 6
  ret i32 %29

30:                                               ; preds = %24, %41
  %31 = phi i32 [ 0, %24 ], [ %42, %41 ]
  %32 = and i32 %31, 15
  %33 = zext i32 %32 to i64
  %34 = getelementptr inbounds i32, ptr %0, i64 %33
  store i32 1048576, ptr %34, align 4, !tbaa !5
  %35 = icmp eq i32 %31, 1
  br i1 %35, label %36, label %41

36:                                               ; preds = %30
  store i32 %26, ptr %27, align 4, !tbaa !5
  %37 = add nuw nsw i32 %31, 2
  %38 = and i32 %37, 15
  %39 = zext i32 %38 to i64
  %40 = getelementptr inbounds i32, ptr %0, i64 %39
  store i32 %25, ptr %40, align 4, !tbaa !5
  br label %41

41:                                               ; preds = %30, %36
  %42 = add nuw nsw i32 %31, 1
  %43 = icmp eq i32 %42, %4
  br i1 %43, label %28, label %30, !llvm.loop !67
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f21(ptr noalias nocapture noundef %0, ptr noalias nocapture noundef writeonly %1, ptr noalias nocapture noundef readonly %2, ptr noalias nocapture noundef readnone %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = icmp eq i32 %4, 0
  br i1 %7, label %13, label %8

8:                                                ; preds = %6
  %9 = tail call i32 @llvm.smax.i32(i32 %5, i32 1)
  br label %10

10:                                               ; preds = %8, %31
  %11 = phi i32 [ 0, %8 ], [ %32, %31 ]
  %12 = phi i32 [ 7, %8 ], [ %44, %31 ]
  br label %24

13:                                               ; preds = %31, %6
  %14 = phi i32 [ 1, %6 ], [ %42, %31 ]
  %15 = phi i32 [ 7, %6 ], [ %44, %31 ]
  %16 = load i32, ptr %2, align 4, !tbaa !5
  %17 = getelementptr inbounds i32, ptr %0, i64 11
  store i32 %16, ptr %17, align 4, !tbaa !5
  %18 = lshr i32 %14, 16
  %19 = and i32 %18, 15
  %20 = zext i32 %19 to i64
  %21 = getelementptr inbounds i32, ptr %0, i64 %20
  store i32 %4, ptr %21, align 4, !tbaa !5
  %22 = xor i32 %15, %4
  %23 = xor i32 %22, %14
  ret i32 %23

24:                                               ; preds = %10, %47
  %25 = phi i32 [ %49, %47 ], [ 0, %10 ]
  %26 = phi i32 [ %44, %47 ], [ %12, %10 ]
  %27 = add i32 %25, 15
  %28 = and i32 %27, 15
  %29 = zext i32 %28 to i64
  %30 = and i32 %25, 15
  br label %34

31:                                               ; preds = %47
  %32 = add nuw nsw i32 %11, 1
  %33 = icmp eq i32 %32, %4
  br i1 %33, label %13, label %10, !llvm.loop !68

34:                                               ; preds = %24, %34
  %35 = phi i32 [ %42, %34 ], [ %26, %24 ]
  %36 = phi i32 [ %44, %34 ], [ %26, %24 ]
  %37 = phi i32 [ %45, %34 ], [ 0, %24 ]
  %38 = and i32 %30, %36
  %39 = zext i32 %38 to i64
  %40 = getelementptr inbounds i32, ptr %0, i64 %39
  %41 = load i32, ptr %40, align 4, !tbaa !5
  %42 = xor i32 %41, %35
  %43 = mul i32 %36, %36
  %44 = add i32 %43, %4
  %45 = add nuw nsw i32 %37, 1
  %46 = icmp eq i32 %45, %9
  br i1 %46, label %47, label %34, !llvm.loop !69

47:                                               ; preds = %34
  %48 = getelementptr inbounds i32, ptr %1, i64 %29
  store i32 0, ptr %48, align 4, !tbaa !5
  %49 = add nuw i32 %25, 1
  %50 = icmp eq i32 %49, %4
  br i1 %50, label %31, label %24, !llvm.loop !70
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f22(ptr noalias nocapture noundef %0, ptr noalias nocapture noundef readonly %1, ptr noalias nocapture noundef readonly %2, ptr noalias nocapture noundef readnone %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = and i32 %4, 7
  %8 = lshr i32 %4, 23
  %9 = mul nuw nsw i32 %7, 3
  %10 = and i32 %9, 15
  %11 = zext i32 %10 to i64
  %12 = getelementptr inbounds i32, ptr %0, i64 %11
  br label %26

13:                                               ; preds = %39
  %14 = and i32 %5, 15
  %15 = and i32 %14, %40
  %16 = zext i32 %15 to i64
  %17 = getelementptr inbounds i32, ptr %2, i64 %16
  %18 = load i32, ptr %17, align 4, !tbaa !5
  %19 = getelementptr inbounds i32, ptr %1, i64 14
  %20 = load i32, ptr %19, align 4, !tbaa !5
  %21 = icmp ult i32 %18, %20
  %22 = zext i1 %21 to i32
  %23 = add i32 %22, %5
  %24 = xor i32 %40, %23
  %25 = xor i32 %24, 7
  ret i32 %25

26:                                               ; preds = %6, %39
  %27 = phi i32 [ %7, %6 ], [ %41, %39 ]
  %28 = phi i32 [ %4, %6 ], [ %40, %39 ]
  %29 = srem i32 %28, 4
  %30 = mul i32 %27, %29
  %31 = add nsw i32 %27, 3
  %32 = and i32 %31, 15
  %33 = zext i32 %32 to i64
  %34 = getelementptr inbounds i32, ptr %0, i64 %33
  store i32 %30, ptr %34, align 4, !tbaa !5
  %35 = icmp slt i32 %27, %7
  br i1 %35, label %36, label %39

36:                                               ; preds = %26
  %37 = load i32, ptr %12, align 4, !tbaa !5
  %38 = or i32 %37, %8
  br label %39

39:                                               ; preds = %36, %26
  %40 = phi i32 [ %38, %36 ], [ %28, %26 ]
  %41 = add nsw i32 %27, -3
  %42 = icmp sgt i32 %27, 2
  br i1 %42, label %26, label %13, !llvm.loop !71
}

; Function Attrs: nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable
define dso_local i32 @f23(ptr noalias nocapture noundef %0, ptr noalias nocapture noundef %1, ptr noalias nocapture noundef readnone %2, ptr noalias nocapture noundef %3, i32 noundef %4, i32 noundef %5) local_unnamed_addr #1 {
  %7 = getelementptr inbounds i32, ptr %1, i64 9
  %8 = add nsw i32 %4, -1
  %9 = icmp sgt i32 %4, 1
  br i1 %9, label %10, label %68

10:                                               ; preds = %6
  %11 = getelementptr inbounds float, ptr %3, i64 15
  %12 = load float, ptr %11, align 4, !tbaa !9
  %13 = fadd float %12, 1.250000e+00
  %14 = getelementptr inbounds float, ptr %3, i64 8
  %15 = getelementptr inbounds i32, ptr %0, i64 3
  %16 = and i32 %5, 1
  %17 = and i32 %5, 8
  %18 = lshr i32 %4, 13
  %19 = lshr i32 %5, 23
  %20 = or i32 %19, %18
  br label %21

21:                                               ; preds = %10, %60
  %22 = phi i32 [ 0, %10 ], [ %66, %60 ]
  %23 = phi i32 [ %4, %10 ], [ %61, %60 ]
  store float %13, ptr %14, align 4, !tbaa !9
  %24 = sub i32 %5, %23
  %25 = icmp slt i32 %24, 8
  br i1 %25, label %26, label %60

26:                                               ; preds = %21
  %27 = load i32, ptr %7, align 4, !tbaa !5
  %28 = shl i32 %27, 7
  %29 = add nuw nsw i32 %22, 2
  %30 = and i32 %29, 14
  %31 = zext i32 %30 to i64
  %32 = getelementptr inbounds i32, ptr %0, i64 %31
  store i32 %28, ptr %32, align 4, !tbaa !5
  %33 = load i32, ptr %15, align 4, !tbaa !5
  %34 = sub i32 %22, %5
  %35 = icmp sgt i32 %33, %34
  br i1 %35, label %68, label %36

36:                                               ; preds = %26
  %37 = add i32 %23, -7
  %38 = icmp sgt i32 %37, %16
  br i1 %38, label %39, label %60

39:                                               ; preds = %36
  %40 = lshr i32 %22, 27
  %41 = mul nsw i32 %22, 3
  %42 = and i32 %41, 14
  %43 = zext i32 %42 to i64
  %44 = getelementptr inbounds float, ptr %3, i64 %43
  %45 = load float, ptr %44, align 4, !tbaa !9
  %46 = fcmp oeq float %45, 1.000000e+00
  %47 = select i1 %46, i32 %40, i32 1
  %48 = icmp ult i32 %47, %17
  br i1 %48, label %55, label %49

49:                                               ; preds = %39
  %50 = and i32 %22, 14
  %51 = or i32 %50, 1
  %52 = zext i32 %51 to i64
  %53 = getelementptr inbounds i32, ptr %0, i64 %52
  %54 = load i32, ptr %53, align 4, !tbaa !5
  br label %57

55:                                               ; preds = %39
  %56 = lshr i32 %22, 20
  br label %57

57:                                               ; preds = %55, %49
  %58 = phi i32 [ %54, %49 ], [ %56, %55 ]
  %59 = getelementptr inbounds i32, ptr %0, i64 %43
  store i32 %58, ptr %59, align 4, !tbaa !5
  br label %60

60:                                               ; preds = %36, %57, %21
  %61 = phi i32 [ %40, %57 ], [ %23, %36 ], [ %23, %21 ]
  %62 = mul nsw i32 %22, 3
  %63 = and i32 %62, 14
  %64 = zext i32 %63 to i64
  %65 = getelementptr inbounds i32, ptr %1, i64 %64
  store i32 %20, ptr %65, align 4, !tbaa !5
  %66 = add nuw nsw i32 %22, 2
  %67 = icmp slt i32 %66, %8
  br i1 %67, label %21, label %68, !llvm.loop !72

68:                                               ; preds = %60, %26, %6
  %69 = phi i32 [ %4, %6 ], [ %61, %60 ], [ %23, %26 ]
  %70 = and i32 %4, 15
  %71 = and i32 %70, %69
  %72 = zext i32 %71 to i64
  %73 = getelementptr inbounds i32, ptr %1, i64 %72
  store i32 %4, ptr %73, align 4, !tbaa !5
  %74 = getelementptr inbounds i32, ptr %0, i64 5
  %75 = load i32, ptr %74, align 4, !tbaa !5
  %76 = and i32 %5, 15
  %77 = zext i32 %76 to i64
  %78 = getelementptr inbounds i32, ptr %0, i64 %77
  store i32 %75, ptr %78, align 4, !tbaa !5
  %79 = icmp slt i32 %4, 0
  br i1 %79, label %137, label %80

80:                                               ; preds = %68
  %81 = getelementptr inbounds float, ptr %3, i64 7
  %82 = and i32 %69, 255
  %83 = sitofp i32 %82 to float
  %84 = icmp eq i32 %4, 0
  %85 = shl i32 %5, 15
  %86 = add i32 %4, -8
  %87 = sub i32 7, %69
  %88 = and i32 %87, 15
  %89 = zext i32 %88 to i64
  %90 = getelementptr inbounds float, ptr %3, i64 %89
  %91 = icmp eq i32 %4, 0
  br label %95

92:                                               ; preds = %126
  %93 = add nsw i32 %96, -1
  %94 = icmp slt i32 %96, 1
  br i1 %94, label %137, label %95, !llvm.loop !73

95:                                               ; preds = %80, %92
  %96 = phi i32 [ %4, %80 ], [ %93, %92 ]
  %97 = phi i32 [ 1, %80 ], [ %127, %92 ]
  %98 = add i32 %96, 15
  %99 = and i32 %98, 15
  %100 = zext i32 %99 to i64
  %101 = getelementptr inbounds float, ptr %3, i64 %100
  br label %115

102:                                              ; preds = %115
  br i1 %84, label %126, label %103

103:                                              ; preds = %102
  %104 = add nuw nsw i32 %96, 1
  %105 = and i32 %104, 15
  %106 = zext i32 %105 to i64
  %107 = getelementptr inbounds float, ptr %3, i64 %106
  %108 = add i32 %96, 14
  %109 = and i32 %108, 15
  %110 = zext i32 %109 to i64
  %111 = add nsw i32 %96, 3
  %112 = and i32 %111, 15
  %113 = zext i32 %112 to i64
  %114 = getelementptr inbounds float, ptr %3, i64 %113
  br label %128

115:                                              ; preds = %95, %115
  %116 = phi i32 [ %4, %95 ], [ %119, %115 ]
  %117 = load float, ptr %81, align 4, !tbaa !9
  %118 = fmul float %117, %83
  store float %118, ptr %101, align 4, !tbaa !9
  %119 = add nsw i32 %116, -1
  %120 = icmp sgt i32 %116, 0
  br i1 %120, label %115, label %102, !llvm.loop !74

121:                                              ; preds = %128
  %122 = getelementptr inbounds i32, ptr %1, i64 %110
  %123 = fcmp oeq float %131, 1.000000e+00
  %124 = select i1 %123, i32 %96, i32 -32768
  %125 = and i32 %124, %85
  store i32 %125, ptr %122, align 4, !tbaa !5
  br label %126

126:                                              ; preds = %121, %102
  %127 = phi i32 [ %132, %121 ], [ %97, %102 ]
  br i1 %91, label %137, label %92

128:                                              ; preds = %103, %128
  %129 = phi i32 [ 0, %103 ], [ %135, %128 ]
  %130 = phi i32 [ %97, %103 ], [ %132, %128 ]
  %131 = load float, ptr %107, align 4, !tbaa !9
  %132 = xor i32 %130, %86
  %133 = load float, ptr %114, align 4, !tbaa !9
  %134 = fadd float %133, 5.000000e-01
  store float %134, ptr %90, align 4, !tbaa !9
  %135 = add nuw nsw i32 %129, 1
  %136 = icmp eq i32 %135, %4
  br i1 %136, label %121, label %128, !llvm.loop !75

137:                                              ; preds = %92, %126, %68
  %138 = phi i1 [ %79, %68 ], [ %94, %92 ], [ %79, %126 ]
  %139 = phi i32 [ 1, %68 ], [ %127, %126 ], [ %127, %92 ]
  %140 = phi i32 [ undef, %68 ], [ %127, %126 ], [ %127, %92 ]
  %141 = xor i32 %69, %139
  %142 = xor i32 %141, 7
  %143 = select i1 %138, i32 %142, i32 %140
  ret i32 %143
}

; Function Attrs: nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare i32 @llvm.smax.i32(i32, i32) #2

; Function Attrs: nocallback nofree nosync nounwind speculatable willreturn memory(none)
declare i32 @llvm.umax.i32(i32, i32) #2

attributes #0 = { nofree norecurse nosync nounwind memory(read, argmem: readwrite, inaccessiblemem: none) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #1 = { nofree norecurse nosync nounwind memory(argmem: readwrite) uwtable "min-legal-vector-width"="0" "no-jump-tables"="true" "no-trapping-math"="true" "stack-protector-buffer-size"="8" "target-cpu"="x86-64" "target-features"="+cx8,+fxsr,+mmx,+sse,+sse2,+x87" "tune-cpu"="generic" }
attributes #2 = { nocallback nofree nosync nounwind speculatable willreturn memory(none) }

!llvm.module.flags = !{!0, !1, !2, !3}
!llvm.ident = !{!4}

!0 = !{i32 1, !"wchar_size", i32 4}
!1 = !{i32 8, !"PIC Level", i32 2}
!2 = !{i32 7, !"PIE Level", i32 2}
!3 = !{i32 7, !"uwtable", i32 2}
!4 = !{!"Debian clang version 16.0.6 (15~deb12u1)"}
!5 = !{!6, !6, i64 0}
!6 = !{!"int", !7, i64 0}
!7 = !{!"omnipotent char", !8, i64 0}
!8 = !{!"Simple C/C++ TBAA"}
!9 = !{!10, !10, i64 0}
!10 = !{!"float", !7, i64 0}
!11 = distinct !{!11, !12, !13}
!12 = !{!"llvm.loop.mustprogress"}
!13 = !{!"llvm.loop.unroll.disable"}
!14 = distinct !{!14, !12, !13}
!15 = distinct !{!15, !12, !13}
!16 = distinct !{!16, !12, !13}
!17 = distinct !{!17, !12, !13}
!18 = distinct !{!18, !12, !13}
!19 = distinct !{!19, !12, !13}
!20 = distinct !{!20, !12, !13}
!21 = distinct !{!21, !12, !13}
!22 = distinct !{!22, !12, !13}
!23 = distinct !{!23, !12, !13}
!24 = distinct !{!24, !12, !13}
!25 = distinct !{!25, !12, !13}
!26 = distinct !{!26, !12, !13}
!27 = distinct !{!27, !12, !13}
!28 = distinct !{!28, !12, !13}
!29 = distinct !{!29, !12, !13}
!30 = distinct !{!30, !12, !13}
!31 = distinct !{!31, !12, !13}
!32 = distinct !{!32, !12, !13}
!33 = distinct !{!33, !12, !13}
!34 = distinct !{!34, !12, !13}
!35 = distinct !{!35, !12, !13}
!36 = distinct !{!36, !12, !13}
!37 = distinct !{!37, !12, !13}
!38 = distinct !{!38, !12, !13}
!39 = distinct !{!39, !12, !13}
!40 = distinct !{!40, !12, !13}
!41 = distinct !{!41, !12, !13}
!42 = distinct !{!42, !12, !13}
!43 = distinct !{!43, !12, !13}
!44 = distinct !{!44, !12, !13}
!45 = distinct !{!45, !12, !13}
!46 = distinct !{!46, !12, !13}
!47 = distinct !{!47, !12, !13}
!48 = distinct !{!48, !12, !13}
!49 = distinct !{!49, !12, !13}
!50 = distinct !{!50, !12, !13}
!51 = distinct !{!51, !12, !13}
!52 = distinct !{!52, !12, !13}
!53 = distinct !{!53, !12, !13}
!54 = distinct !{!54, !12, !13}
!55 = distinct !{!55, !12, !13}
!56 = distinct !{!56, !12, !13}
!57 = distinct !{!57, !12, !13}
!58 = distinct !{!58, !12, !13}
!59 = distinct !{!59, !12, !13}
!60 = distinct !{!60, !12, !13}
!61 = distinct !{!61, !12, !13}
!62 = distinct !{!62, !12, !13}
!63 = distinct !{!63, !12, !13}
!64 = distinct !{!64, !12, !13}
!65 = distinct !{!65, !12, !13}
!66 = distinct !{!66, !12, !13}
!67 = distinct !{!67, !12, !13}
!68 = distinct !{!68, !12, !13}
!69 = distinct !{!69, !12, !13}
!70 = distinct !{!70, !12, !13}
!71 = distinct !{!71, !12, !13}
!72 = distinct !{!72, !12, !13}
!73 = distinct !{!73, !12, !13}
!74 = distinct !{!74, !12, !13}
!75 = distinct !{!75, !12, !13}
